// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string_view>

#include "datasets/mocap/line_reader.h"
#include "datasets/mocap/motive_header.h"

namespace trilat {

bool is_trc(std::string_view first_line);

// The header of a TRC as OpenSim, Pose2Sim and OpenCap write it, of which `first_line` has been read already;
// the next line is then the first of the data. The row of names says which markers there are and where; the
// other rows are asked for rate, unit and count alone. Axes stay as they are. InputError with the line where
// something is missing or contradictory.
ColumnHeader read_trc_header(LineReader& lines, std::string_view first_line);

// Holds the header's rate against the times of the first rows: where they differ by more than rounding, or no
// rate is stated, the times count, and `taken_as` says so. InputError where there is neither.
void settle_trc_rate(const std::filesystem::path& path, MocapHeader& header);

}  // namespace trilat
