// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "datasets/base/described.h"
#include "datasets/geometry/rigid_transform.h"
#include "datasets/results/studies/calibration_summary.h"
#include "pipeline/calibration_study/calibration_study.h"
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

// One error and the cluster it belongs to (a unit, a run): errors of one cluster have causes in common.
struct ClusteredError {
  std::size_t cluster = 0;
  double error_m = ErrorSpread::kNone;  // NaN: no answer
};

// Mean, spread and quantiles, with an interval of the mean by bootstrap over clusters (none with fewer than
// four). `seed` makes the resampling; equal inputs give equal results.
ErrorSpread spread_of(const std::vector<ClusteredError>& errors, std::uint64_t seed);

// How an error of a pose (rotation vector, rad; position, m) stands to the covariance that is stated for it.
// 0 axes where none is.
struct PoseMisfit {
  double rotation_z2 = ErrorSpread::kNone,
         position_z2 = ErrorSpread::kNone;   // (error / sigma)^2, mean of 3 axes
  double mahalanobis2 = ErrorSpread::kNone;  // of all six together
  std::uint64_t covered = 0, asked = 0;      // axes whose 95 % interval holds the truth
  TRILAT_FIELDS(rotation_z2, position_z2, mahalanobis2, covered, asked)
};
PoseMisfit misfit_of(const Eigen::Matrix<double, 6, 1>& error, const Eigen::Matrix<double, 6, 6>& covariance);

}  // namespace trilat
