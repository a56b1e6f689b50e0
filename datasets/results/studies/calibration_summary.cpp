// SPDX-License-Identifier: MIT
#include "datasets/results/studies/calibration_summary.h"

#include <cmath>

#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/results/results_file.h"

namespace trilat {
namespace {

// NaN becomes null.
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json numbers(const std::vector<double>& values) {
  Json json = Json::array();
  for (double value : values) json.push_back(number(value));
  return json;
}

std::vector<double> read_numbers(JsonObject& object, const std::string& key) {
  const Json& values = object.value(key);
  if (!values.is_array()) object.refuse(key, "must be an array of numbers");
  std::vector<double> result;
  for (const Json& value : values) {
    if (!value.is_number() && !value.is_null()) object.refuse(key, "must hold numbers and nulls only");
    result.push_back(value.is_number() ? value.get<double>() : ErrorSpread::kNone);
  }
  return result;
}

Json json_of(const ErrorSpread& s) {
  return {{"asked", s.asked},
          {"answered", s.answered},
          {"mean_m", number(s.mean_m)},
          {"sd_m", number(s.sd_m)},
          {"median_m", number(s.median_m)},
          {"p95_m", number(s.p95_m)},
          {"max_m", number(s.max_m)},
          {"mean_low_m", number(s.mean_low_m)},
          {"mean_high_m", number(s.mean_high_m)}};
}

ErrorSpread read_spread(JsonObject object) {
  ErrorSpread s;
  s.asked = object.count("asked");
  s.answered = object.count("answered");
  s.mean_m = number_or_nan(object, "mean_m");
  s.sd_m = number_or_nan(object, "sd_m");
  s.median_m = number_or_nan(object, "median_m");
  s.p95_m = number_or_nan(object, "p95_m");
  s.max_m = number_or_nan(object, "max_m");
  s.mean_low_m = number_or_nan(object, "mean_low_m");
  s.mean_high_m = number_or_nan(object, "mean_high_m");
  object.finish();
  return s;
}

Json json_of(const WandRow& row) {
  return {{"method", row.method},
          {"scene", row.scene},
          {"all", json_of(row.all)},
          {"recommended", json_of(row.recommended)},
          {"near", json_of(row.near)},
          {"statuses", counts_json(row.statuses)},
          {"recommended_distance", json_of(row.recommended_distance)}};
}

WandRow read_wand_row(JsonObject& object) {
  WandRow row;
  row.method = object.text("method");
  row.scene = object.text("scene");
  row.all = read_spread(object.object("all"));
  row.recommended = read_spread(object.object("recommended"));
  row.near = read_spread(object.object("near"));
  row.statuses = read_counts(object.object("statuses"));
  row.recommended_distance = read_spread(object.object("recommended_distance"));
  object.finish();
  return row;
}

constexpr const char* kSample = "[row, unit, distance_m, angle_rad, error_m, distance_error_m]";

Json json_of(const WandSample& s) {
  return {s.row, s.unit, s.distance_m, s.angle_rad, number(s.error_m), number(s.distance_error_m)};
}

WandSample read_sample(const Json& v, std::size_t rows, JsonObject& object, const std::string& key) {
  const auto is_error = [](const Json& e) { return e.is_number() || e.is_null(); };
  const bool right = v.is_array() && v.size() == 6 && v[0].is_number_unsigned() &&
                     v[1].is_number_unsigned() && v[2].is_number() && v[3].is_number() && is_error(v[4]) &&
                     is_error(v[5]);
  if (!right || v[0].get<std::uint64_t>() >= rows)
    object.refuse(key, std::string("must hold ") + kSample + " of rows that are there");
  const auto error_m = [](const Json& e) { return e.is_number() ? e.get<double>() : ErrorSpread::kNone; };
  return {v[0].get<std::size_t>(), v[1].get<std::uint64_t>(),
          v[2].get<double>(),      v[3].get<double>(),
          error_m(v[4]),           error_m(v[5])};
}

std::vector<WandSample> read_samples(JsonObject& object, std::size_t rows) {
  const std::string key = "wand_samples";
  const Json& values = object.value(key);
  if (!values.is_array()) object.refuse(key, "must be an array");
  std::vector<WandSample> samples;
  for (const Json& v : values) samples.push_back(read_sample(v, rows, object, key));
  return samples;
}

Json json_of(const DistortionCurve& c) {
  return {{"wall_m", c.wall_m},
          {"frames", c.frames},
          {"unit", c.unit},
          {"unit_offset_m", c.unit_offset_m},
          {"valid", c.valid},
          {"depth_error_m", numbers(c.depth_error_m)},
          {"depth_residual_m", numbers(c.depth_residual_m)},
          {"printed_error_m", numbers(c.printed_error_m)},
          {"lens_error_m", numbers(c.lens_error_m)}};
}

DistortionCurve read_curve(JsonObject& object) {
  DistortionCurve c;
  c.wall_m = object.number("wall_m");
  c.frames = object.count("frames");
  c.unit = object.count("unit");
  c.unit_offset_m = object.number("unit_offset_m");
  for (double count : read_numbers(object, "valid")) {
    if (!(count >= 0.0 && count <= static_cast<double>(c.frames)))
      object.refuse("valid", "must hold counts from 0 to the number of frames");
    c.valid.push_back(static_cast<std::uint64_t>(count));
  }
  c.depth_error_m = read_numbers(object, "depth_error_m");
  c.depth_residual_m = read_numbers(object, "depth_residual_m");
  c.printed_error_m = read_numbers(object, "printed_error_m");
  c.lens_error_m = read_numbers(object, "lens_error_m");
  for (const auto* curve : {&c.depth_error_m, &c.depth_residual_m, &c.printed_error_m, &c.lens_error_m})
    if (curve->size() != c.valid.size()) object.refuse("valid", "must be as long as the curves");
  object.finish();
  return c;
}

Json json_of(const RigRow& r) {
  return {{"method", r.method},
          {"runs", r.runs},
          {"failed_runs", r.failed_runs},
          {"position", json_of(r.position)},
          {"rotation_mean_rad", number(r.rotation_mean_rad)},
          {"rotation_max_rad", number(r.rotation_max_rad)},
          {"within_limits_share", number(r.within_limits_share)},
          {"coverage_share", number(r.coverage_share)},
          {"coverage_low", number(r.coverage_low)},
          {"coverage_high", number(r.coverage_high)},
          {"position_z_rms", number(r.position_z_rms)},
          {"rotation_z_rms", number(r.rotation_z_rms)},
          {"mahalanobis2_mean", number(r.mahalanobis2_mean)},
          {"reduced_chi2_mean", number(r.reduced_chi2_mean)}};
}

RigRow read_rig_row(JsonObject& object) {
  RigRow r;
  r.method = object.text("method");
  r.runs = object.count("runs");
  r.failed_runs = object.count("failed_runs");
  r.position = read_spread(object.object("position"));
  r.rotation_mean_rad = number_or_nan(object, "rotation_mean_rad");
  r.rotation_max_rad = number_or_nan(object, "rotation_max_rad");
  r.within_limits_share = number_or_nan(object, "within_limits_share");
  r.coverage_share = number_or_nan(object, "coverage_share");
  r.coverage_low = number_or_nan(object, "coverage_low");
  r.coverage_high = number_or_nan(object, "coverage_high");
  r.position_z_rms = number_or_nan(object, "position_z_rms");
  r.rotation_z_rms = number_or_nan(object, "rotation_z_rms");
  r.mahalanobis2_mean = number_or_nan(object, "mahalanobis2_mean");
  r.reduced_chi2_mean = number_or_nan(object, "reduced_chi2_mean");
  object.finish();
  return r;
}

Json json_of(const EffectRow& e) {
  return {{"calibration", e.calibration},
          {"sensor_sigma_m", number(e.sensor_sigma_m)},
          {"range_sigma_m", e.range_sigma_m},
          {"method", e.method},
          {"joints", e.joints},
          {"answered", e.answered},
          {"rmse_m", number(e.rmse_m)},
          {"bound_m", number(e.bound_m)},
          {"ratio_low", number(e.ratio_low)},
          {"ratio_high", number(e.ratio_high)}};
}

EffectRow read_effect(JsonObject& object) {
  EffectRow e;
  e.calibration = object.text("calibration");
  e.sensor_sigma_m = number_or_nan(object, "sensor_sigma_m");
  e.range_sigma_m = object.number("range_sigma_m");
  e.method = object.text("method");
  e.joints = object.count("joints");
  e.answered = object.count("answered");
  e.rmse_m = number_or_nan(object, "rmse_m");
  e.bound_m = number_or_nan(object, "bound_m");
  e.ratio_low = number_or_nan(object, "ratio_low");
  e.ratio_high = number_or_nan(object, "ratio_high");
  object.finish();
  return e;
}

template <class T>
Json list_of(const std::vector<T>& values) {
  Json json = Json::array();
  for (const T& value : values) json.push_back(json_of(value));
  return json;
}

template <class T>
std::vector<T> read_list(JsonObject& object, const std::string& key, T (*read)(JsonObject&)) {
  std::vector<T> values;
  for (JsonObject& entry : object.objects(key)) values.push_back(read(entry));
  return values;
}

}  // namespace

void write_calibration_summary(const std::filesystem::path& folder, const CalibrationSummary& s) {
  Json json = results_head(StudyKind::calibration);
  json["study"] = s.study;
  json["simulated"] = true;
  json["seed"] = s.seed;
  json["samples"] = s.samples;
  json["units"] = s.units;
  json["frames"] = s.frames;
  json["ball_radius_m"] = s.ball_radius_m;
  json["positions"] = s.positions;
  json["wand"] = list_of(s.wand);
  json["wand_samples"] = list_of(s.wand_samples);
  json["distortion"] = list_of(s.distortion);
  json["rigs"] = list_of(s.rigs);
  json["effect"] = list_of(s.effect);
  write_file(folder / "summary.json", json_text(json, -1) + "\n");
}

CalibrationSummary read_calibration_summary(const std::filesystem::path& folder) {
  const Json json = read_results_json(folder);
  JsonObject object(json, (folder / "summary.json").string(), "");
  check_results_head(object, StudyKind::calibration);
  CalibrationSummary s;
  s.study = object.text("study");
  object.boolean("simulated", true);
  s.seed = object.count("seed");
  s.samples = object.count("samples");
  s.units = object.count("units");
  s.frames = object.count("frames");
  s.ball_radius_m = object.number("ball_radius_m");
  s.positions = object.count("positions");
  s.wand = read_list<WandRow>(object, "wand", read_wand_row);
  s.wand_samples = read_samples(object, s.wand.size());
  s.distortion = read_list<DistortionCurve>(object, "distortion", read_curve);
  s.rigs = read_list<RigRow>(object, "rigs", read_rig_row);
  s.effect = read_list<EffectRow>(object, "effect", read_effect);
  object.finish();
  return s;
}

}  // namespace trilat
