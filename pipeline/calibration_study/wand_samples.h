// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/calibration_study/calibration_study.h"
#include "pipeline/calibration_study/calibration_summary.h"
#include "pipeline/calibration_study/simulated_run.h"
#include "pipeline/study/study.h"

namespace trilat {

struct WandSampleResults {
  std::vector<WandRow> rows;
  std::vector<WandSample> samples;  // of the whole span; those nearer than 0.5 m are in the rows only
};

// The paper's calibration figure: the error of one wand position, the mean of a few frames, against distance
// and angle; as the paper prints it, with each erratum alone as printed, and ours; the ball alone before a
// far wall, and in a room with the person who holds it. An item a unit.
std::vector<Item> wand_items(const CalibrationSpec& spec);
WandSampleResults read_wand(const CalibrationSpec& spec, const Outcomes& outcomes);

// One error and the cluster it belongs to (a unit, a run): errors of one cluster have causes in common.
struct ClusteredError {
  std::size_t cluster = 0;
  double error_m = ErrorSpread::kNone;  // NaN: no answer
};

// Mean, spread and quantiles, with a 95 % interval of the mean by Student's t between clusters.
ErrorSpread spread_of(const std::vector<ClusteredError>& errors);

}  // namespace trilat
