// SPDX-License-Identifier: MIT
#include "datasets/results/declared_parameters.h"

#include "datasets/results/results_file.h"

namespace trilat {
namespace {

struct Parameters {
  static constexpr const char* kFile = "simulator.json";
  std::vector<DeclaredParameter> parameters;
  static void fields(auto& self, auto&& f) {
    f.format("trilat.simulator");
    f("parameters", self.parameters);
  }
};

}  // namespace

void write_declared_parameters(const std::filesystem::path& folder,
                               const std::vector<DeclaredParameter>& parameters) {
  write_beside(folder, Parameters{parameters});
}

std::vector<DeclaredParameter> read_declared_parameters(const std::filesystem::path& folder) {
  return read_beside<Parameters>(folder).value_or(Parameters{}).parameters;
}

}  // namespace trilat
