// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "evaluators/fusion/range_bearing.h"

namespace trilat {

// How a sensor stands and measures beside what its calibration says. Covariance: of (turn, shift, range).
struct PoseCorrection {
  Eigen::Vector3d rotation_rad = Eigen::Vector3d::Zero();  // rotation vector about the sensor, in the world
  Eigen::Vector3d translation_m =
      Eigen::Vector3d::Zero();  // what it sees is so far from its place, in the world
  double range_m = 0.0;         // its ranges are so much too long
  Eigen::Matrix<double, 7, 7> covariance = Eigen::Matrix<double, 7, 7>::Zero();
  std::size_t views = 0;         // that it was found from
  double residual_rms_m = kNaN;  // of these, an axis; NaN without any
};

// The pose and the view without what the correction says.
RigidTransform corrected_pose(const RigidTransform& world_from_sensor, const PoseCorrection& correction);
JointObservation corrected_view(const JointObservation& observation, const RigidTransform& world_from_sensor,
                                const PoseCorrection& correction);

// Standard deviations of a sensor's turn, shift (each an axis) and range offset before anything was seen.
// Positive.
struct PosePriors {
  double rotation_rad = 0.03;
  double translation_m = 0.01;
  double range_m = 0.015;
};

struct SelfCalibration {
  std::vector<PoseCorrection> of_sensor;  // one each, zero when there is a problem
  std::size_t rows = 0, joints = 0;       // that were used
  std::string problem;                    // why nothing could be told; empty when something could
};

// How much a sensor is turned (rad), shifted (m) and measures too far (m), with 95 % intervals of Student's t
// over the joints. Of turn and shift the median of the length; from 0 where there may be none.
struct Interval {
  double value = kNaN, low = kNaN, high = kNaN;
};
struct CorrectionMagnitudes {
  Interval rotation_rad, translation_m, range_m;
};
CorrectionMagnitudes magnitudes_of(const SelfCalibration& calibration, std::size_t sensor);

// Corrections of a rig's calibration by the joints of one person, without truth: for each sensor a turn
// about its position, a shift and an offset of its ranges, with normal priors. Rounds go on, eight at least,
// until no parameter moves by a tenth of its standard deviation; where one still does after 40 there is a
// `problem`. Each round estimates the variances along and across the rays (restricted maximum likelihood, as
// estimate_ray_sigma()), linearises, eliminates the joints' places (Schur complement), gives views that
// disagree by more than three sigmas less weight (Cauchy), and solves (k^2 H / tau + Lambda) theta = k g /
// tau, k the mean curvature of that loss over its weights. tau is the design effect: how much the scores of
// whole joints vary beyond what independent views would, so that the tracker's constant error of a joint
// counts once and not once an instant. Lambda has two parts. The rig's mean keeps the stated priors: what
// turns, shifts or lengthens all sensors together shows in little disagreement, and errors of the tracker
// would pass for it. How sensors differ from that mean has priors that are estimated again from the third
// round on (empirical Bayes), those of shift and range offset only downwards, because narrow rigs would drift
// away; in the covariance the stated ones count beside them as eight parameters. One sensor, or sensors that
// never see the same joint, tell nothing: `problem`. `observations`: rows times sensors of the rig; `joint`:
// of each row. InternalError when the sizes do not fit or a prior is not positive.
[[nodiscard]] SelfCalibration self_calibrate(std::span<const JointObservation> observations,
                                             std::span<const RigidTransform> world_from_sensor,
                                             std::span<const std::uint32_t> joint,
                                             const PosePriors& priors = {});

}  // namespace trilat
