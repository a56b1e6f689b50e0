// SPDX-License-Identifier: MIT
#include "datasets/results/speed_file.h"

#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/results/results_file.h"

namespace trilat {
namespace {

std::vector<double> read_ratios(JsonObject& entry, const std::string& key) {
  const Json& list = entry.value(key);
  if (!list.is_array() || list.empty()) entry.refuse(key, "must be a list of numbers");
  std::vector<double> ratios;
  for (const Json& ratio : list) {
    if (!ratio.is_number() || !(ratio.get<double>() > 0.0)) entry.refuse(key, "must hold positive numbers");
    ratios.push_back(ratio.get<double>());
  }
  return ratios;
}

}  // namespace

void write_speed(const std::filesystem::path& folder, const SpeedFile& speed) {
  Json json{{"format", "trilat.speed"},         {"version", 1},
            {"processor", speed.processor},     {"reference", speed.reference},
            {"problems", speed.problems},       {"reference_ns", speed.reference_ns},
            {"others_busy", speed.others_busy}, {"solvers", Json::array()}};
  for (const SolverSpeed& s : speed.solvers)
    json["solvers"].push_back({{"solver", s.solver}, {"median_ns", s.median_ns}, {"ratios", s.ratios}});
  write_file(folder / "speed.json", json_text(json, 1) + "\n");
}

std::optional<SpeedFile> read_speed(const std::filesystem::path& folder) {
  const auto path = folder / "speed.json";
  if (!std::filesystem::exists(path)) return std::nullopt;
  const Json json = read_json(path);
  JsonObject object(json, path.string(), "");
  check_format(object, "trilat.speed", 1);
  SpeedFile speed;
  speed.processor = object.text("processor");
  speed.reference = object.text("reference");
  speed.problems = object.count("problems");
  speed.reference_ns = object.positive("reference_ns");
  speed.others_busy = object.number("others_busy", 0.0);
  for (JsonObject& entry : object.objects("solvers")) {
    SolverSpeed solver;
    solver.solver = entry.text("solver");
    solver.median_ns = entry.positive("median_ns");
    solver.ratios = read_ratios(entry, "ratios");
    entry.finish();
    speed.solvers.push_back(std::move(solver));
  }
  object.finish();
  return speed;
}

}  // namespace trilat
