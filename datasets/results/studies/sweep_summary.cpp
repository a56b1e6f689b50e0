// SPDX-License-Identifier: MIT
#include "datasets/results/studies/sweep_summary.h"

#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/results/results_file.h"

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

Json json_of(const SweepFit& fit) {
  return {{"interpretation", fit.interpretation},
          {"reported", fit.reported},
          {"rms_log_ratio", fit.rms_log_ratio},
          {"worst_factor", fit.worst_factor},
          {"us_per_iteration", fit.us_per_iteration}};
}

Json json_of(const SweepRanking& ranking) {
  Json json{{"ranked", ranking.ranked},
            {"best_rms", ranking.best_rms},
            {"median_rms", ranking.median_rms},
            {"worst_rms", ranking.worst_rms},
            {"best", Json::array()}};
  for (const SweepFit& fit : ranking.best) json["best"].push_back(json_of(fit));
  return json;
}

Json json_of(const SweepCompromise& c) {
  return {{"best_for", c.best_for},
          {"printed", c.printed},
          {"corrected", c.corrected},
          {"printed_iterations_factor", c.printed_iterations_factor},
          {"corrected_iterations_factor", c.corrected_iterations_factor},
          {"printed_error_factor", c.printed_error_factor},
          {"corrected_error_factor", c.corrected_error_factor},
          {"printed_coverage", c.printed_coverage},
          {"corrected_coverage", c.corrected_coverage}};
}

std::size_t read_index(JsonObject& object, const std::string& key, std::size_t interpretations) {
  const std::uint64_t index = object.count(key);
  if (index >= interpretations) object.refuse(key, "is the number of no interpretation");
  return index;
}

SweepFit read_fit(JsonObject& object, std::size_t interpretations) {
  SweepFit fit;
  fit.interpretation = read_index(object, "interpretation", interpretations);
  fit.reported = object.text("reported");
  fit.rms_log_ratio = object.number("rms_log_ratio");
  fit.worst_factor = object.number("worst_factor");
  fit.us_per_iteration = number_or_nan(object, "us_per_iteration");
  object.finish();
  return fit;
}

SweepRanking read_ranking(JsonObject object, std::size_t interpretations) {
  SweepRanking ranking;
  ranking.ranked = object.count("ranked");
  ranking.best_rms = number_or_nan(object, "best_rms");
  ranking.median_rms = number_or_nan(object, "median_rms");
  ranking.worst_rms = number_or_nan(object, "worst_rms");
  for (JsonObject& fit : object.objects("best")) ranking.best.push_back(read_fit(fit, interpretations));
  object.finish();
  return ranking;
}

std::vector<double> read_factors(JsonObject& object, const std::string& key, std::size_t ranges) {
  const Json& values = object.value(key);
  if (!values.is_array() || values.empty() || values.size() != ranges)
    object.refuse(key, "must be an array of a number for each range");
  std::vector<double> factors;
  for (const Json& value : values)
    factors.push_back(value.is_number() ? value.get<double>() : SweepCell::kNone);
  return factors;
}

SweepCompromise read_compromise(JsonObject& object, std::size_t interpretations, std::size_t ranges) {
  SweepCompromise c;
  c.best_for = object.text("best_for");
  c.printed = read_index(object, "printed", interpretations);
  c.corrected = read_index(object, "corrected", interpretations);
  c.printed_iterations_factor = read_factors(object, "printed_iterations_factor", ranges);
  c.corrected_iterations_factor = read_factors(object, "corrected_iterations_factor", ranges);
  c.printed_error_factor = read_factors(object, "printed_error_factor", ranges);
  c.corrected_error_factor = read_factors(object, "corrected_error_factor", ranges);
  c.printed_coverage = number_or_nan(object, "printed_coverage");
  c.corrected_coverage = number_or_nan(object, "corrected_coverage");
  object.finish();
  return c;
}

std::array<double, 3> read_three(const Json& value, const JsonObject& object, const std::string& key) {
  std::array<double, 3> three{SweepCell::kNone, SweepCell::kNone, SweepCell::kNone};
  if (!value.is_array() || value.size() != 3) object.refuse(key, "must be an array of 3 numbers");
  for (std::size_t i = 0; i < 3; ++i)
    if (value[i].is_number()) three[i] = value[i].get<double>();
  return three;
}

}  // namespace

void write_sweep_summary(const std::filesystem::path& folder, const SweepSummary& s) {
  Json json = results_head(StudyKind::threshold_sweep);
  json["study"] = s.study;
  json["simulated"] = s.simulated;
  json["seed"] = s.seed;
  json["trials"] = s.trials;
  json["max_iterations"] = s.max_iterations;
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

Json json_of(const SweepSearch& search) {
  Json json{{"tried", search.tried},
            {"errors", json_of(search.errors)},
            {"times", json_of(search.times)},
            {"compromises", Json::array()}};
  for (const SweepCompromise& c : search.compromises) json["compromises"].push_back(json_of(c));
  return json;
}

SweepSearch read_search(JsonObject object, std::size_t interpretations, std::size_t ranges) {
  SweepSearch search;
  search.tried = object.count("tried");
  search.errors = read_ranking(object.object("errors"), interpretations);
  search.times = read_ranking(object.object("times"), interpretations);
  for (JsonObject& c : object.objects("compromises"))
    search.compromises.push_back(read_compromise(c, interpretations, ranges));
  object.finish();
  return search;
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

SweepCell read_sweep_cell(JsonObject& object) {
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

}  // namespace trilat
