// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <optional>
#include <vector>

#include "datasets/mocap/mocap_take.h"

namespace trilat {

// Whether the first line is that of a format below; the rest of the file is not looked at.
bool is_mocap_file(const std::filesystem::path& path);

// The header alone. InputError when the file cannot be opened or is in none of these formats.
MocapHeader read_mocap_header(const std::filesystem::path& path);

// Part of a motion capture that is read.
struct MocapPart {
  std::optional<std::vector<std::size_t>> assets = {};        // of the header; all of them
  MocapTime until{std::numeric_limits<std::int64_t>::max()};  // through the first frame at it
  std::size_t block_bytes = 1 << 20;                          // read from the disk at once
};

// A motion capture as it is written: OptiTrack's exports (Motive's column format 1.2 to 1.25), and the
// markers of TRC files; the content says which. Positions come out in metres. InputError with the place where
// something makes no sense.
MocapTake read_mocap(const std::filesystem::path& path, const MocapPart& part = {});
// Reads a motion capture without positions that are no measurement: see remove_missing().
MocapTake read_positions(const std::filesystem::path& path, const MocapPart& part = {});

// Whether a file begins with a row of column names that has time_s and joint.
bool is_joint_csv(const std::filesystem::path& path);
// The joints of such a file, as markers, without positions that are no measurement: a row a time and joint,
// in any order, with the columns time_s, joint, x_m, y_m, z_m; other columns are not read. A position of
// which a number is blank or not finite is missing. InputError with the row.
MocapTake read_joint_csv(const std::filesystem::path& path);

}  // namespace trilat
