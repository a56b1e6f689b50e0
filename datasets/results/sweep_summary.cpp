// SPDX-License-Identifier: MIT
#include "datasets/results/sweep_summary.h"

#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/results/results_file.h"
#include "datasets/results/sweep_cell_json.h"
#include "datasets/results/sweep_search_json.h"

namespace trilat {
namespace {

Json json_of(const SweepInterpretation& i) {
  return {{"id", i.id},
          {"rig", i.rig},
          {"sensors_m", i.sensors_m},
          {"joint", i.joint},
          {"error_model", i.error_model},
          {"threshold_unit", i.threshold_unit},
          {"gradient", i.gradient},
          {"curvature", i.curvature},
          {"stop", i.stop},
          {"damping", i.damping},
          {"start", i.start}};
}

std::array<double, 3> read_position(const Json& value, const JsonObject& object, const std::string& key) {
  std::array<double, 3> position{};
  bool fits = value.is_array() && value.size() == 3;
  for (std::size_t i = 0; fits && i < 3; ++i) {
    fits = value[i].is_number();
    if (fits) position[i] = value[i].get<double>();
  }
  if (!fits) object.refuse(key, "must be positions, each an array of 3 numbers");
  return position;
}

SweepInterpretation read_interpretation(JsonObject& object) {
  SweepInterpretation i;
  i.id = object.text("id");
  i.rig = object.text("rig");
  const Json& sensors = object.value("sensors_m");
  if (!sensors.is_array()) object.refuse("sensors_m", "must be an array of positions");
  for (const Json& sensor : sensors) i.sensors_m.push_back(read_position(sensor, object, "sensors_m"));
  i.joint = object.text("joint");
  i.error_model = object.text("error_model");
  i.threshold_unit = object.text("threshold_unit");
  i.gradient = object.text("gradient");
  i.curvature = object.text("curvature");
  i.stop = object.text("stop");
  i.damping = object.text("damping");
  i.start = object.text("start");
  object.finish();
  return i;
}

SweepSummary::ErrorRange read_range(JsonObject& object) {
  const SweepSummary::ErrorRange range{object.number("low_m"), object.number("high_m")};
  object.finish();
  return range;
}

void check_cells(const SweepSummary& s, const JsonObject& object) {
  const std::size_t thresholds = s.thresholds.size(), ranges = s.ranges.size();
  bool fits = s.cells.size() == s.interpretations.size() * thresholds * ranges;
  for (std::size_t i = 0; fits && i < s.cells.size(); ++i)
    fits = s.cells[i].interpretation == i / ranges / thresholds &&
           s.cells[i].threshold == i / ranges % thresholds && s.cells[i].range == i % ranges;
  if (!fits)
    object.refuse("cells", "must hold one cell for every interpretation, threshold and range, in this order");
}

}  // namespace

void write_sweep_summary(const std::filesystem::path& folder, const SweepSummary& s) {
  Json json = results_head(StudyKind::threshold_sweep);
  json["study"] = s.study;
  json["simulated"] = s.simulated;
  json["seed"] = s.seed;
  json["trials"] = s.trials;
  json["max_iterations"] = s.max_iterations;
  json["interrupted"] = s.interrupted;
  json["skipped"] = s.skipped;
  json["thresholds"] = s.thresholds;
  for (const char* list : {"ranges", "interpretations", "cells"}) json[list] = Json::array();
  for (const auto& range : s.ranges)
    json["ranges"].push_back({{"low_m", range.low_m}, {"high_m", range.high_m}});
  for (const SweepInterpretation& i : s.interpretations) json["interpretations"].push_back(json_of(i));
  for (const SweepCell& cell : s.cells) json["cells"].push_back(json_of(cell));
  if (s.search) json["search"] = json_of(*s.search);
  write_file(folder / "summary.json", json_text(json, 1) + "\n");
}

SweepSummary read_sweep_summary(const std::filesystem::path& folder) {
  const Json json = read_results_json(folder);
  JsonObject object(json, (folder / "summary.json").string(), "");
  check_results_head(object, StudyKind::threshold_sweep);
  SweepSummary s;
  s.study = object.text("study");
  s.simulated = object.boolean("simulated", true);
  s.seed = object.count("seed");
  s.trials = object.count("trials");
  s.max_iterations = object.count("max_iterations");
  s.interrupted = object.boolean("interrupted", false);
  s.skipped = object.count("skipped");
  s.thresholds = object.numbers("thresholds", object.value("thresholds").size());
  for (JsonObject& range : object.objects("ranges")) s.ranges.push_back(read_range(range));
  for (JsonObject& i : object.objects("interpretations")) s.interpretations.push_back(read_interpretation(i));
  for (JsonObject& cell : object.objects("cells")) s.cells.push_back(read_sweep_cell(cell));
  if (object.has("search"))
    s.search = read_search(object.object("search"), s.interpretations.size(), s.ranges.size());
  object.finish();
  check_cells(s, object);
  return s;
}

}  // namespace trilat
