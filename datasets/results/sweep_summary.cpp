// SPDX-License-Identifier: MIT
#include "datasets/results/sweep_summary.h"

#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/results/results_file.h"
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

std::array<double, 3> read_three(const Json& value, const JsonObject& object, const std::string& key) {
  std::array<double, 3> three{SweepCell::kNone, SweepCell::kNone, SweepCell::kNone};
  if (!value.is_array() || value.size() != 3) object.refuse(key, "must be an array of 3 numbers");
  for (std::size_t i = 0; i < 3; ++i)
    if (value[i].is_number()) three[i] = value[i].get<double>();
  return three;
}

SweepInterpretation read_interpretation(JsonObject& object) {
  SweepInterpretation i;
  i.id = object.text("id");
  i.rig = object.text("rig");
  const Json& sensors = object.value("sensors_m");
  if (!sensors.is_array()) object.refuse("sensors_m", "must be an array of positions");
  for (const Json& sensor : sensors) i.sensors_m.push_back(read_three(sensor, object, "sensors_m"));
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

Json json_of(const SweepCell& cell) {
  return {{"interpretation", cell.interpretation},
          {"threshold", cell.threshold},
          {"range", cell.range},
          {"asked", cell.asked},
          {"answered", cell.answered},
          {"statuses", counts_json(cell.statuses)},
          {"mae_m", cell.mae_m},
          {"mae_standard_error_m", cell.mae_standard_error_m},
          {"axis_mae_m", cell.axis_mae_m},
          {"axis_mean_mae_m", cell.axis_mean_mae_m()},
          {"rmse_m", cell.rmse_m},
          {"p50_m", cell.p50_m},
          {"p95_m", cell.p95_m},
          {"max_m", cell.max_m},
          {"start_mae_m", cell.start_mae_m},
          {"mean_iterations", cell.mean_iterations},
          {"p50_iterations", cell.p50_iterations},
          {"p99_iterations", cell.p99_iterations},
          {"max_iterations", cell.max_iterations},
          {"digits_trials", cell.digits_trials},
          {"mean_digits", cell.mean_digits},
          {"p50_digits", cell.p50_digits},
          {"min_digits", cell.min_digits}};
}

SweepCell read_cell(JsonObject& object) {
  SweepCell cell;
  cell.interpretation = object.count("interpretation");
  cell.threshold = object.count("threshold");
  cell.range = object.count("range");
  cell.asked = object.count("asked");
  cell.answered = object.count("answered");
  cell.statuses = read_counts(object.object("statuses"));
  cell.mae_m = number_or_nan(object, "mae_m");
  cell.mae_standard_error_m = number_or_nan(object, "mae_standard_error_m");
  cell.axis_mae_m = read_three(object.value("axis_mae_m"), object, "axis_mae_m");
  number_or_nan(object, "axis_mean_mae_m");
  cell.rmse_m = number_or_nan(object, "rmse_m");
  cell.p50_m = number_or_nan(object, "p50_m");
  cell.p95_m = number_or_nan(object, "p95_m");
  cell.max_m = number_or_nan(object, "max_m");
  cell.start_mae_m = number_or_nan(object, "start_mae_m");
  cell.mean_iterations = number_or_nan(object, "mean_iterations");
  cell.p50_iterations = number_or_nan(object, "p50_iterations");
  cell.p99_iterations = number_or_nan(object, "p99_iterations");
  cell.max_iterations = number_or_nan(object, "max_iterations");
  cell.digits_trials = object.count("digits_trials");
  cell.mean_digits = number_or_nan(object, "mean_digits");
  cell.p50_digits = number_or_nan(object, "p50_digits");
  cell.min_digits = number_or_nan(object, "min_digits");
  object.finish();
  return cell;
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
  Json json = results_head(ResultsKind::threshold_sweep);
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
  check_results_head(object, ResultsKind::threshold_sweep);
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
  for (JsonObject& cell : object.objects("cells")) s.cells.push_back(read_cell(cell));
  if (object.has("search"))
    s.search = read_search(object.object("search"), s.interpretations.size(), s.ranges.size());
  object.finish();
  check_cells(s, object);
  return s;
}

}  // namespace trilat
