// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/base/described.h"
#include "datasets/results/samples.h"
#include "datasets/results/studies/tracking_summary.h"
#include "pipeline/accuracy/take/take_data.h"

namespace trilat {

// How far predictions by one method are from what the sensor sees that is left out, summed over instants and
// joints: along its ray (length of the prediction's vector - length of what is seen) and across (distance of
// the prediction from the line of sight). Metres, before any alignment.
struct PredictionSums {
  std::string participant, condition, method;
  std::uint64_t n = 0;
  double range_m = 0.0, abs_range_m = 0.0, bearing_m = 0.0;

  TRILAT_FIELDS(participant, condition, method, n, range_m, abs_range_m, bearing_m)
};

// Of a take whose sensor is left out, after which no method sees that sensor: its tracked joints become the
// truth. Inferred ones are the tracker's guess and do not. Does nothing to other takes. InputError when that
// sensor never tracks a joint that is asked for.
void leave_out(const Plan& plan, const PlannedTake& planned, TakeData& data);

// Adds what a block says; `sums` gets an entry for every method of the plan, none for takes with mocap.
void add_predictions(const Plan& plan, const PlannedTake& planned, const SampleBlock& block,
                     std::vector<PredictionSums>& sums);

// By condition and method, in the order of their first take; intervals between participants.
std::vector<PredictionRow> prediction_rows(const std::vector<PredictionSums>& sums);

}  // namespace trilat
