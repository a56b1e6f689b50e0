// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "datasets/mocap/mocap_reader.h"

namespace trilat {

// Whether a file begins with a row of column names that has time_s and joint.
bool is_joint_csv(const std::filesystem::path& path);
// The joints of such a file, as markers: a row a time and joint, in any order, with the columns time_s,
// joint, x_m, y_m, z_m; other columns are not read. A position of which a number is blank or not finite is
// missing. InputError with the row.
MocapPositions read_joint_csv(const std::filesystem::path& path);

}  // namespace trilat
