// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace trilat {

// One solver's time as multiples of the reference's, a round each, in the order they were measured.
struct SolverSpeed {
  std::string solver;
  std::vector<double> ratios;
  double median_ns = 0.0;  // a solve, for the reader
};

// How fast solvers were against a reference of the same run.
struct SpeedFile {
  std::string processor;
  std::string reference;  // name and version of what ratios are to
  std::uint64_t problems = 0;
  double reference_ns = 0.0;  // median a solve
  double others_busy = 0.0;   // how many processors other programs kept busy meanwhile
  std::vector<SolverSpeed> solvers;
};

// speed.json (trilat.speed, version 1), in a results folder or a folder that holds several.
void write_speed(const std::filesystem::path& folder, const SpeedFile& speed);
// Nothing when the folder has none; InputError when it is not one.
std::optional<SpeedFile> read_speed(const std::filesystem::path& folder);

}  // namespace trilat
