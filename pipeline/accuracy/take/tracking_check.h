// SPDX-License-Identifier: MIT
#pragma once

#include "datasets/base/described.h"
#include "pipeline/accuracy/take/angle_errors.h"
#include "pipeline/accuracy/take/left_out.h"
#include "pipeline/accuracy/take/take_data.h"
#include "pipeline/accuracy/tracking_summary.h"

namespace trilat {

// What one take says of how its sensors tracked, as rows of one condition.
struct TakeTracking {
  std::vector<ViewRow> views;
  std::vector<ExchangeRow> exchanges;
  ClockRow clock;
  RayRow rays = {};
  std::vector<CorrectionRow> corrections = {};
  std::vector<PredictionSums> predictions = {};
  std::vector<AngleSums> angles = {};

  TRILAT_FIELDS(views, exchanges, predictions, clock, rays, corrections, angles)
};

// Counts which views each rule and each method with an occlusion rule rejects, and which exchanges of left
// and right were found.
TakeTracking check_tracking(const Plan& plan, const PlannedTake& planned, const TakeData& data);

// Adds up takes in their order: rows of one condition, sensor, group and rule become one.
TrackingSummary sum_tracking(const Plan& plan, const std::vector<TakeTracking>& takes);

}  // namespace trilat
