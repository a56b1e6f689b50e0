// SPDX-License-Identifier: MIT
#pragma once

#include "datasets/base/described.h"
#include "datasets/results/studies/tracking_summary.h"
#include "pipeline/accuracy/take/left_out.h"
#include "pipeline/accuracy/take/take_data.h"

namespace trilat {

// The errors of one joint group's ranges in one take.
struct RangeSums {
  std::string condition, group;
  std::uint64_t n = 0;
  double sum_m = 0.0, squares_m2 = 0.0;

  TRILAT_FIELDS(condition, group, n, sum_m, squares_m2)
};

// What one take says of how its sensors tracked, as rows of one condition.
struct TakeTracking {
  std::vector<ViewRow> views;
  std::vector<ExchangeRow> exchanges;
  ClockRow clock;
  RayRow rays = {};
  std::vector<CorrectionRow> corrections = {};
  std::vector<RangeSums> ranges;
  std::vector<PredictionSums> predictions = {};

  TRILAT_FIELDS(views, exchanges, ranges, predictions, clock, rays, corrections)
};

// Counts which views each rule and each method with an occlusion rule rejects, and which exchanges of left
// and right were found; beside the simulator's truth where the take has it. InputError when that truth cannot
// be read.
TakeTracking check_tracking(const Plan& plan, const PlannedTake& planned, const TakeData& data);

// Adds up takes in their order: rows of one condition, sensor, group and rule become one.
TrackingSummary sum_tracking(const Plan& plan, const std::vector<TakeTracking>& takes);

}  // namespace trilat
