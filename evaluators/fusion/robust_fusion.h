// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "datasets/depth/depth_rays.h"
#include "evaluators/fusion/joint_observation.h"
#include "evaluators/solvers/point_estimate.h"

namespace trilat {

// Means of the sensors' own joint positions that trust some sensors more than others. They end as the
// baselines do: closed_form (converged when they iterate), no_observation or non_finite_input.

struct WeightedMeanOptions {
  SensorMask allowed = kAllSensors;
  // Of an inferred joint against a tracked one: 1/9 when it is three times as uncertain.
  double inferred_weight = 1.0 / 9.0;
  // Weights are also the inverse variance of the depth noise at the joint's range, seen head on.
  bool by_depth_noise = true;
  AxialNoise noise{};
};
[[nodiscard]] PointEstimate solve_weighted_mean(std::span<const JointObservation> observations,
                                                const WeightedMeanOptions& options);

// The point from which the distances to the sensors' positions sum to the least (geometric median; Newton's
// iteration, held by Weiszfeld's as Vardi and Zhang 2000 made it safe at the data points). Of two positions
// the one in the middle. A single wrong sensor of three or more cannot pull it far, and it does not depend on
// the axes as a median of each coordinate would.
struct MedianOptions {
  SensorMask allowed = kAllSensors;
  double step_tolerance_m = 1e-9;
  int max_iterations = 1000;
};
[[nodiscard]] PointEstimate solve_median(std::span<const JointObservation> observations,
                                         const MedianOptions& options);

// M-estimate with Cauchy's loss, started from the geometric median: positions farther than about `scale_m`
// from the others count less and less.
struct RobustMeanOptions {
  SensorMask allowed = kAllSensors;
  double scale_m = 0.05;
  double step_tolerance_m = 1e-9;
  int max_iterations = 1000;
};
[[nodiscard]] PointEstimate solve_robust_mean(std::span<const JointObservation> observations,
                                              const RobustMeanOptions& options);

}  // namespace trilat
