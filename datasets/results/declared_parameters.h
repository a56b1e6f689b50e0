// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/base/described.h"

namespace trilat {

// A value that a simulation assumes, and what it rests on.
struct DeclaredParameter {
  std::string name, value, unit, source;
  bool operator==(const DeclaredParameter&) const = default;

  TRILAT_FIELDS(name, value, unit, source)
};

// The source of a value that is not the declared default.
inline constexpr const char* kSetInTheSimulation = "set in the simulation";

// simulator.json, in a simulated campaign and in the results that come from it.
void write_declared_parameters(const std::filesystem::path& folder,
                               const std::vector<DeclaredParameter>& parameters);
// Empty when there is no such file; InputError when it is not one of these.
std::vector<DeclaredParameter> read_declared_parameters(const std::filesystem::path& folder);

}  // namespace trilat
