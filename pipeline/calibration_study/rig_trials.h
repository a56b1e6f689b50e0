// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "datasets/base/described.h"
#include "pipeline/calibration_study/calibration_study.h"
#include "pipeline/calibration_study/calibration_summary.h"
#include "pipeline/study/study.h"

namespace trilat {

// Whole rigs calibrated again and again, each run with other units, wand positions and noise: as the paper
// prints it, with each erratum alone as printed, corrected, and ours from wand and from bodies. Images are
// rendered as a sensor would make them; only the ball's way from place to place is left out. An item a run.
std::vector<Item> rig_items(const CalibrationSpec& spec);
std::vector<RigRow> read_rigs(const CalibrationSpec& spec, const Outcomes& outcomes);

// The poses of the study's rig.
std::vector<RigidTransform> true_rig(const CalibrationSpec& spec);

// Error of a pose (rotation vector, rad; position, m) relative to its stated covariance. 0 axes without one.
struct PoseMisfit {
  double rotation_z2 = ErrorSpread::kNone,
         position_z2 = ErrorSpread::kNone;   // (error / sigma)^2, mean of 3 axes
  double mahalanobis2 = ErrorSpread::kNone;  // of all six together
  std::uint64_t covered = 0, asked = 0;      // axes whose 95 % interval holds the truth
  TRILAT_FIELDS(rotation_z2, position_z2, mahalanobis2, covered, asked)
};
PoseMisfit misfit_of(const Eigen::Matrix<double, 6, 1>& error, const Eigen::Matrix<double, 6, 6>& covariance);

}  // namespace trilat
