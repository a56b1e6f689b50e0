// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/results/studies/calibration_summary.h"
#include "pipeline/calibration_study/calibration_study.h"
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

}  // namespace trilat
