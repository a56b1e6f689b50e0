// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

#include "datasets/mocap/line_reader.h"
#include "datasets/mocap/motive_header.h"

namespace trilat {

// A file of nothing but markers, with tabs between the cells, of which `first_line` has been read already;
// the next line is then the first of the data. Axes stay as they are. InputError with the line where
// something is missing or contradictory.

bool is_trc(std::string_view first_line);
// OpenSim's TRC: lengths in the unit that the header states.
ColumnHeader read_trc_header(LineReader& lines, std::string_view first_line);

}  // namespace trilat
