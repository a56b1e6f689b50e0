// SPDX-License-Identifier: MIT
#include "datasets/results/summary_cells.h"

#include <nlohmann/json.hpp>

#include "datasets/results/results_file.h"

namespace trilat {
namespace {

// Three numbers, or nulls that stand for NaN.
std::array<double, 3> read_three(JsonObject& object, const std::string& key) {
  std::array<double, 3> result{kNoNumber, kNoNumber, kNoNumber};
  const Json& values = object.value(key);
  if (!values.is_array() || values.size() != 3) object.refuse(key, "must be an array of 3");
  for (std::size_t i = 0; i < 3; ++i) {
    if (!values[i].is_number() && !values[i].is_null()) object.refuse(key, "must hold numbers or null");
    if (values[i].is_number()) result[i] = values[i].get<double>();
  }
  return result;
}

}  // namespace

Json json_of(const SummaryCell& cell) {
  return {{"method", cell.method},
          {"condition", cell.condition},
          {"group", cell.group},
          {"alignment", cell.alignment},
          {"asked", cell.asked},
          {"answered", cell.answered},
          {"coverage", cell.coverage()},
          {"statuses", counts_json(cell.statuses)},
          {"mae_m", cell.mae_m},
          {"axis_mae_m", cell.axis_mae_m},
          {"rmse_m", cell.rmse_m},
          {"p05_m", cell.p05_m},
          {"p25_m", cell.p25_m},
          {"median_m", cell.median_m},
          {"p75_m", cell.p75_m},
          {"p90_m", cell.p90_m},
          {"p95_m", cell.p95_m},
          {"max_m", cell.max_m},
          {"mean_gdop", cell.mean_gdop},
          {"rms_gdop", cell.rms_gdop},
          {"gdop_rmse_m", cell.gdop_rmse_m},
          {"mean_iterations", cell.mean_iterations},
          {"mae_low_m", cell.mae_low_m},
          {"mae_high_m", cell.mae_high_m},
          {"clusters", cell.clusters},
          {"one_frame_m", cell.one_frame_m}};
}

SummaryCell read_cell(JsonObject& object) {
  SummaryCell cell;
  cell.method = object.text("method");
  cell.condition = object.text("condition");
  cell.group = object.text("group");
  cell.alignment = object.text("alignment");
  cell.asked = object.count("asked");
  cell.answered = object.count("answered");
  number_or_nan(object, "coverage");
  cell.statuses = read_counts(object.object("statuses"));
  cell.mae_m = number_or_nan(object, "mae_m");
  cell.axis_mae_m = read_three(object, "axis_mae_m");
  cell.rmse_m = number_or_nan(object, "rmse_m");
  cell.p05_m = number_or_nan(object, "p05_m");
  cell.p25_m = number_or_nan(object, "p25_m");
  cell.median_m = number_or_nan(object, "median_m");
  cell.p75_m = number_or_nan(object, "p75_m");
  cell.p90_m = number_or_nan(object, "p90_m");
  cell.p95_m = number_or_nan(object, "p95_m");
  cell.max_m = number_or_nan(object, "max_m");
  cell.mean_gdop = number_or_nan(object, "mean_gdop");
  cell.rms_gdop = number_or_nan(object, "rms_gdop");
  cell.gdop_rmse_m = number_or_nan(object, "gdop_rmse_m");
  cell.mean_iterations = number_or_nan(object, "mean_iterations");
  cell.mae_low_m = number_or_nan(object, "mae_low_m");
  cell.mae_high_m = number_or_nan(object, "mae_high_m");
  cell.clusters = object.count("clusters");
  cell.one_frame_m = number_or_nan(object, "one_frame_m");
  object.finish();
  return cell;
}

Json json_of(const DifferenceCell& cell) {
  return {{"method", cell.method},
          {"condition", cell.condition},
          {"group", cell.group},
          {"alignment", cell.alignment},
          {"n", cell.n},
          {"clusters", cell.clusters},
          {"difference_m", cell.difference_m},
          {"low_m", cell.low_m},
          {"high_m", cell.high_m},
          {"significant", cell.significant()},
          {"percent_of_reference", cell.percent_of_reference},
          {"percent_low", cell.percent_low},
          {"percent_high", cell.percent_high},
          {"percent_of_method", cell.percent_of_method},
          {"complete_percent", cell.complete_percent},
          {"complete_percent_low", cell.complete_percent_low},
          {"complete_percent_high", cell.complete_percent_high}};
}

DifferenceCell read_difference(JsonObject& object) {
  DifferenceCell cell;
  cell.method = object.text("method");
  cell.condition = object.text("condition");
  cell.group = object.text("group");
  cell.alignment = object.text("alignment");
  cell.n = object.count("n");
  cell.clusters = object.count("clusters");
  cell.difference_m = number_or_nan(object, "difference_m");
  cell.low_m = number_or_nan(object, "low_m");
  cell.high_m = number_or_nan(object, "high_m");
  if (object.boolean("significant", false) != cell.significant())
    object.refuse("significant", "does not follow from low_m and high_m");
  cell.percent_of_reference = number_or_nan(object, "percent_of_reference");
  cell.percent_low = number_or_nan(object, "percent_low");
  cell.percent_high = number_or_nan(object, "percent_high");
  cell.percent_of_method = number_or_nan(object, "percent_of_method");
  cell.complete_percent = number_or_nan(object, "complete_percent");
  cell.complete_percent_low = number_or_nan(object, "complete_percent_low");
  cell.complete_percent_high = number_or_nan(object, "complete_percent_high");
  object.finish();
  return cell;
}

Json json_of(const BodyCell& cell) {
  return {{"method", cell.method},
          {"condition", cell.condition},
          {"alignment", cell.alignment},
          {"instants", cell.instants},
          {"clusters", cell.clusters},
          {"mpjpe_m", cell.mpjpe_m},
          {"mpjpe_low_m", cell.mpjpe_low_m},
          {"mpjpe_high_m", cell.mpjpe_high_m},
          {"pa_mpjpe_m", cell.pa_mpjpe_m},
          {"pa_mpjpe_low_m", cell.pa_mpjpe_low_m},
          {"pa_mpjpe_high_m", cell.pa_mpjpe_high_m},
          {"pck_5cm_10cm_15cm", cell.pck},
          {"bones", cell.bones},
          {"bone_length_sd_m", cell.bone_length_sd_m},
          {"jitter_m_s3", cell.jitter_m_s3},
          {"truth_jitter_m_s3", cell.truth_jitter_m_s3}};
}

BodyCell read_body(JsonObject& object) {
  BodyCell cell;
  cell.method = object.text("method");
  cell.condition = object.text("condition");
  cell.alignment = object.text("alignment");
  cell.instants = object.count("instants");
  cell.clusters = object.count("clusters");
  cell.mpjpe_m = number_or_nan(object, "mpjpe_m");
  cell.mpjpe_low_m = number_or_nan(object, "mpjpe_low_m");
  cell.mpjpe_high_m = number_or_nan(object, "mpjpe_high_m");
  cell.pa_mpjpe_m = number_or_nan(object, "pa_mpjpe_m");
  cell.pa_mpjpe_low_m = number_or_nan(object, "pa_mpjpe_low_m");
  cell.pa_mpjpe_high_m = number_or_nan(object, "pa_mpjpe_high_m");
  cell.pck = read_three(object, "pck_5cm_10cm_15cm");
  cell.bones = object.count("bones");
  cell.bone_length_sd_m = number_or_nan(object, "bone_length_sd_m");
  cell.jitter_m_s3 = number_or_nan(object, "jitter_m_s3");
  cell.truth_jitter_m_s3 = number_or_nan(object, "truth_jitter_m_s3");
  object.finish();
  return cell;
}

Json json_of(const TruthFloor& floor) {
  return {{"condition", floor.condition},         {"group", floor.group},
          {"mocap_noise_m", floor.mocap_noise_m}, {"mean_speed_m_s", floor.mean_speed_m_s},
          {"clock_error_s", floor.clock_error_s}, {"clock_m", floor.clock_m()}};
}

TruthFloor read_floor(JsonObject& object) {
  TruthFloor floor;
  floor.condition = object.text("condition");
  floor.group = object.text("group");
  floor.mocap_noise_m = number_or_nan(object, "mocap_noise_m");
  floor.mean_speed_m_s = number_or_nan(object, "mean_speed_m_s");
  floor.clock_error_s = number_or_nan(object, "clock_error_s");
  number_or_nan(object, "clock_m");
  object.finish();
  return floor;
}

}  // namespace trilat
