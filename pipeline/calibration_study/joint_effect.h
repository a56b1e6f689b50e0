// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include "datasets/base/described.h"
#include "datasets/geometry/rigid_transform.h"
#include "datasets/results/studies/calibration_summary.h"
#include "pipeline/calibration_study/calibration_spec.h"
#include "pipeline/study/watch.h"

namespace trilat {

// Poses of one rig's sensors as somebody has calibrated them, in the true world.
struct CalibratedRig {
  std::vector<RigidTransform> world_from_sensor;
  TRILAT_FIELDS(world_from_sensor)
};
// What one method made of the rig, in several runs.
struct RigCalibrations {
  std::string method;
  std::vector<CalibratedRig> runs;
};

// How uncertain sensors carry into joints, against the Cramer-Rao bound of the same geometry: with the
// study's sensor errors (independent, normal, an axis) and with what calibrations really gave. Every case
// sees the same joints and the same range errors.
std::vector<EffectRow> measure_effect(const CalibrationSpec& spec, const std::vector<RigidTransform>& truth,
                                      std::span<const RigCalibrations> calibrations, const Watch& watch);

}  // namespace trilat
