// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "datasets/rig/rigid_transform.h"
#include "evaluators/wand/ball_fit.h"

namespace trilat {

// One point (a wand position, a joint at an instant) as one sensor measured it.
struct PointObservation {
  std::size_t sensor = 0;
  std::size_t point = 0;
  Eigen::Vector3d point_in_sensor_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Identity();
  DepthSensitivity depth = {};  // of what the sensor's depth is off by; looked at where that is estimated
};

// Observations of the same points by sensors whose poses are wanted. At most one observation a sensor and
// point.
struct RigProblem {
  std::size_t sensors = 0;
  std::size_t points = 0;
  std::vector<PointObservation> observations;
};

// Whether a sensor could be placed beside the others, and if not why.
enum class SensorPlacement : std::uint8_t {
  placed,
  nothing_seen,    // no observation at all
  no_common_view,  // fewer than 3 points in common with any sensor that is placed
  points_on_line,  // the common points lie on a line: the turn about it is undetermined
  disagrees,       // no rigid motion brings 3 of the common points within the tolerance
};

struct RigStartOptions {
  double tolerance_m = 0.05;      // a common point farther off than this does not support a motion
  double least_breadth_m = 0.05;  // root mean square spread of the common points across their main direction
  int tries = 300;                // triples of points tried a pair of sensors, the same in every run
};

struct RigStart {
  std::vector<SensorPlacement> placement;             // one a sensor
  std::vector<RigidTransform> reference_from_sensor;  // of the sensors that are placed
  std::size_t reference = 0;                          // the sensor with most observations
  bool complete() const;
};

// Poses to start a refinement from: for every pair of sensors the rigid motion that most of their common
// points support (three points at a time, Fischler and Bolles 1981; then least squares on the inliers,
// Horn 1987), chained from the reference along the best supported pairs. Wrong points may be among them.
[[nodiscard]] RigStart initial_poses(const RigProblem& problem, const RigStartOptions& options);

}  // namespace trilat
