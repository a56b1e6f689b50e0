// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "evaluators/fusion/joint_observation.h"
#include "evaluators/solvers/point_estimate.h"

namespace trilat {

// Estimates from the sensors' own joint positions, without trilateration. They end with closed_form,
// no_observation or, for a point that is not finite, non_finite_input. Cost, gdop and covariance stay NaN: no
// ranges are fitted.

struct SingleSensorOptions {
  int sensor = 0;  // the rig's number
};
[[nodiscard]] PointEstimate solve_single_sensor(std::span<const JointObservation> observations,
                                                const SingleSensorOptions& options);

struct MeanOptions {
  SensorMask allowed = kAllSensors;
  // Average only those that are tracked rather than inferred; when none is, all that see the joint.
  bool prefer_tracked = false;
  // The position farthest from the median of all is left out where it is farther than this; 0: none is.
  double outlier_m = 0.0;
};
[[nodiscard]] PointEstimate solve_mean(std::span<const JointObservation> observations,
                                       const MeanOptions& options);

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

}  // namespace trilat
