// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace trilat {

// What a program took from its start to its end.
struct ProgramCost {
  double cpu_s = 0.0, wall_s = 0.0;
  long peak_kb = 0;
  void add(const ProgramCost& other) {
    cpu_s += other.cpu_s;
    wall_s += other.wall_s;
  }
};

// Runs a program to its end with its standard output in a file; ends this program when it fails.
ProgramCost cost_of(std::vector<std::string> arguments, const std::filesystem::path& output);

}  // namespace trilat
