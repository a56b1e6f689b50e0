// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

#include "datasets/mocap/line_reader.h"
#include "datasets/mocap/motive_header.h"

namespace trilat {

// Files of nothing but markers, with tabs between the cells, of which `first_line` has been read already; the
// next line is then the first of the data. Axes stay as they are: both formats are right-handed. InputError
// with the line where something is missing or contradictory.

bool is_trc(std::string_view first_line);
// OpenSim's TRC: lengths in the unit that the header states.
ColumnHeader read_trc_header(LineReader& lines, std::string_view first_line);

bool is_qualisys(std::string_view first_line);
// The 3D export of Qualisys Track Manager: millimetres; frame and time may lead a row or not.
ColumnHeader read_qualisys_header(LineReader& lines, std::string_view first_line);

}  // namespace trilat
