// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/base/document.h"

namespace trilat {

// A value that a simulation assumes, and what it rests on.
struct SimulationAssumption {
  std::string name, value, unit, source;
  bool operator==(const SimulationAssumption&) const = default;

  static void fields(auto& self, auto&& f) {
    f("name", self.name, "value", self.value, "unit", self.unit, "source", self.source);
  }
};

// The source of a value that is not the declared default.
inline constexpr const char* kSetInTheSimulation = "set in the simulation";

// simulator.json, in a simulated campaign and in the results that come from it.
void write_simulation_assumptions(const std::filesystem::path& folder,
                                  const std::vector<SimulationAssumption>& parameters);
// Empty when there is no such file; InputError when it is not one of these.
std::vector<SimulationAssumption> read_simulation_assumptions(const std::filesystem::path& folder);

}  // namespace trilat
