// SPDX-License-Identifier: MIT
#pragma once

#include "datasets/results/tracking_summary.h"
#include "pipeline/take_data.h"

namespace trilat {

// What one take says of how its sensors tracked, as rows of one condition.
struct TakeTracking {
  std::vector<ViewRow> views;
  std::vector<ExchangeRow> exchanges;
  ClockRow clock;
};

// Counts which views each rule and each method with an occlusion rule rejects, and which exchanges of left
// and right were found; beside the simulator's truth where the take has it. InputError when that truth cannot
// be read.
TakeTracking check_tracking(const Plan& plan, const PlannedTake& planned, const TakeData& data);

// Adds up takes in their order: rows of one condition, sensor, group and rule become one.
TrackingSummary sum_tracking(const Plan& plan, const std::vector<TakeTracking>& takes);

}  // namespace trilat
