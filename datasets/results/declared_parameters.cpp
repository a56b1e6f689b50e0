// SPDX-License-Identifier: MIT
#include "datasets/results/declared_parameters.h"

#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/base/strict_json.h"
#include "datasets/results/results_file.h"

namespace trilat {
namespace {

constexpr const char* kParametersFormat = "trilat.simulator";
constexpr const char* kName = "simulator.json";

}  // namespace

void write_declared_parameters(const std::filesystem::path& folder,
                               const std::vector<DeclaredParameter>& parameters) {
  Json json{{"format", kParametersFormat}, {"version", 1}, {"parameters", Json::array()}};
  for (const DeclaredParameter& p : parameters)
    json["parameters"].push_back(
        {{"name", p.name}, {"value", p.value}, {"unit", p.unit}, {"source", p.source}});
  write_file(folder / kName, json.dump(1) + "\n");
}

std::vector<DeclaredParameter> read_declared_parameters(const std::filesystem::path& folder) {
  std::vector<DeclaredParameter> parameters;
  const auto path = folder / kName;
  if (!std::filesystem::exists(path)) return parameters;
  const Json json = read_json(path);
  JsonObject object(json, path.string(), "");
  check_format(object, kParametersFormat, 1);
  for (JsonObject& entry : object.objects("parameters")) {
    parameters.push_back({entry.text("name"), entry.text("value"), entry.text("unit"), entry.text("source")});
    entry.finish();
  }
  object.finish();
  return parameters;
}

}  // namespace trilat
