// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/results/studies/calibration_summary.h"
#include "pipeline/calibration_study/calibration_study.h"
#include "pipeline/calibration_study/joint_effect.h"
#include "pipeline/calibration_study/simulated_run.h"
#include "pipeline/study/study.h"

namespace trilat {

struct RigTrialResults {
  std::vector<RigRow> rows;
  std::vector<RigCalibrations> calibrations;  // of the methods that place every sensor, for measure_effect()
};

// Whole rigs calibrated again and again, each run with other units, wand positions and noise: as the paper
// prints it, with each erratum alone as printed, corrected, and ours from wand and from bodies. Images are
// rendered as a sensor would make them; only the ball's way from place to place is left out. An item a run.
std::vector<Item> rig_items(const CalibrationSpec& spec);
RigTrialResults read_rigs(const CalibrationSpec& spec, const Outcomes& outcomes);

// The poses of the study's rig.
std::vector<RigidTransform> true_rig(const CalibrationSpec& spec);

}  // namespace trilat
