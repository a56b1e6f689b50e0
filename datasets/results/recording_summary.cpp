// SPDX-License-Identifier: MIT
#include "datasets/results/recording_summary.h"

#include <cmath>

#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/results/results_file.h"

namespace trilat {
namespace {

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }

}  // namespace

Json json_of(const ClockErrorRow& r) {
  return {{"network", r.network},
          {"method", r.method},
          {"asked", r.asked},
          {"error", json_of(r.error)},
          {"below_2ms", number(r.below_2ms)},
          {"below_2ms_low", number(r.below_2ms_low)},
          {"below_2ms_high", number(r.below_2ms_high)}};
}

ClockErrorRow read_clock_error(JsonObject object) {
  ClockErrorRow r;
  r.network = object.text("network");
  r.method = object.text("method");
  r.asked = object.count("asked");
  r.error = read_time_spread(object.object("error"));
  r.below_2ms = number_or_nan(object, "below_2ms");
  r.below_2ms_low = number_or_nan(object, "below_2ms_low");
  r.below_2ms_high = number_or_nan(object, "below_2ms_high");
  object.finish();
  return r;
}

Json json_of(const ClockFitRow& r) {
  return {{"network", r.network},
          {"offset_sigma_s", number(r.offset_sigma_s)},
          {"offset_bound_s", number(r.offset_bound_s)},
          {"within_bound_share", number(r.within_bound_share)},
          {"exchanges_used_share", number(r.exchanges_used_share)}};
}

ClockFitRow read_clock_fit(JsonObject object) {
  ClockFitRow r;
  r.network = object.text("network");
  r.offset_sigma_s = number_or_nan(object, "offset_sigma_s");
  r.offset_bound_s = number_or_nan(object, "offset_bound_s");
  r.within_bound_share = number_or_nan(object, "within_bound_share");
  r.exchanges_used_share = number_or_nan(object, "exchanges_used_share");
  object.finish();
  return r;
}

void write_recording_summary(const std::filesystem::path& folder, const RecordingSummary& s) {
  Json json = results_head(ResultsKind::recording);
  json["study"] = s.study;
  json["simulated"] = true;
  json["seed"] = s.seed;
  json["interrupted"] = s.interrupted;
  json["frames"] = s.frames;
  json["sensors"] = s.sensors;
  json["runs"] = s.runs;
  json["clocks"] = Json::array();
  for (const ClockErrorRow& row : s.clocks) json["clocks"].push_back(json_of(row));
  json["fits"] = Json::array();
  for (const ClockFitRow& row : s.fits) json["fits"].push_back(json_of(row));
  write_file(folder / "summary.json", json_text(json, -1) + "\n");
}

RecordingSummary read_recording_summary(const std::filesystem::path& folder) {
  const Json json = read_results_json(folder);
  JsonObject object(json, (folder / "summary.json").string(), "");
  check_results_head(object, ResultsKind::recording);
  RecordingSummary s;
  s.study = object.text("study");
  object.boolean("simulated", true);
  s.seed = object.count("seed");
  s.interrupted = object.boolean("interrupted", false);
  s.frames = object.count("frames");
  s.sensors = object.count("sensors");
  s.runs = object.count("runs");
  for (JsonObject& entry : object.objects("clocks")) s.clocks.push_back(read_clock_error(entry));
  for (JsonObject& entry : object.objects("fits")) s.fits.push_back(read_clock_fit(entry));
  object.finish();
  return s;
}

}  // namespace trilat
