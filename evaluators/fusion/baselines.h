// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "evaluators/fusion/joint_observation.h"
#include "evaluators/solvers/point_estimate.h"

namespace trilat {

// What the sensors' own joint positions give without trilateration. They end with closed_form, no_observation
// or, for a point that is not finite, non_finite_input. Cost, gdop and covariance stay NaN: no ranges are
// fitted.

struct SingleSensorOptions {
  int sensor = 0;  // the rig's number
};
[[nodiscard]] PointEstimate solve_single_sensor(std::span<const JointObservation> observations,
                                                const SingleSensorOptions& options);

struct MeanOptions {
  SensorMask allowed = kAllSensors;
  // Average only those that are tracked rather than inferred; when none is, all that see the joint.
  bool prefer_tracked = false;
};
[[nodiscard]] PointEstimate solve_mean(std::span<const JointObservation> observations,
                                       const MeanOptions& options);

}  // namespace trilat
