// SPDX-License-Identifier: MIT
#include "datasets/results/declared_parameters.h"

#include "datasets/results/results_file.h"

namespace trilat {
namespace {

constexpr const char* kParametersFormat = "trilat.simulator";
constexpr const char* kName = "simulator.json";

struct Parameters {
  std::vector<DeclaredParameter> parameters;
  TRILAT_FIELDS(parameters)
};

}  // namespace

void write_declared_parameters(const std::filesystem::path& folder,
                               const std::vector<DeclaredParameter>& parameters) {
  write_beside(folder / kName, kParametersFormat, Parameters{parameters});
}

std::vector<DeclaredParameter> read_declared_parameters(const std::filesystem::path& folder) {
  return read_beside<Parameters>(folder / kName, kParametersFormat).value_or(Parameters{}).parameters;
}

}  // namespace trilat
