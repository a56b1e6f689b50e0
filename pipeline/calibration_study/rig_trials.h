// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "datasets/results/calibration_summary.h"
#include "pipeline/calibration_study/calibration_spec.h"
#include "pipeline/calibration_study/joint_effect.h"
#include "pipeline/calibration_study/study_units.h"
#include "pipeline/items/study_items.h"

namespace trilat {

struct RigTrialResults {
  std::vector<RigRow> rows;
  std::vector<RigCalibrations> calibrations;  // of the methods that place every sensor, for measure_effect()
};

// Whole rigs calibrated again and again, each run with other units, wand positions and noise: as the paper
// prints it, with each erratum alone as printed, corrected, and ours from wand and from bodies. Images are
// rendered as a sensor would make them; only the ball's way from place to place is left out. `scratch` is a
// folder for recordings of walking, removed one by one. An item a run; without results when some are another
// shard's.
RigTrialResults measure_rigs(const CalibrationSpec& spec, const std::filesystem::path& scratch,
                             StudyItems& items, const StudyHooks& hooks);
std::vector<PartItem> rig_items(const CalibrationSpec& spec);

// The poses of the study's rig.
std::vector<RigidTransform> true_rig(const CalibrationSpec& spec);

}  // namespace trilat
