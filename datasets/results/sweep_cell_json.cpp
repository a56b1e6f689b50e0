// SPDX-License-Identifier: MIT
#include "datasets/results/sweep_cell_json.h"

#include <nlohmann/json.hpp>

#include "datasets/results/results_file.h"

namespace trilat {
namespace {

std::array<double, 3> read_three(const Json& value, const JsonObject& object, const std::string& key) {
  std::array<double, 3> three{SweepCell::kNone, SweepCell::kNone, SweepCell::kNone};
  if (!value.is_array() || value.size() != 3) object.refuse(key, "must be an array of 3 numbers");
  for (std::size_t i = 0; i < 3; ++i)
    if (value[i].is_number()) three[i] = value[i].get<double>();
  return three;
}

}  // namespace

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
