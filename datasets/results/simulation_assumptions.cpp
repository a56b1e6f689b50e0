// SPDX-License-Identifier: MIT
#include "datasets/results/simulation_assumptions.h"

#include "datasets/results/results_file.h"

namespace trilat {
namespace {

struct Parameters {
  static constexpr const char* kFile = "simulator.json";
  std::vector<SimulationAssumption> parameters;
  static void fields(auto& self, auto&& f) {
    f.format("trilat.simulator");
    f("parameters", self.parameters);
  }
};

}  // namespace

void write_simulation_assumptions(const std::filesystem::path& folder,
                                  const std::vector<SimulationAssumption>& parameters) {
  write_json_file(folder, Parameters{parameters});
}

std::vector<SimulationAssumption> read_simulation_assumptions(const std::filesystem::path& folder) {
  return read_json_file<Parameters>(folder).value_or(Parameters{}).parameters;
}

}  // namespace trilat
