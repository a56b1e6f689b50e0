// SPDX-License-Identifier: MIT
#pragma once

#include <bitset>
#include <span>

#include <Eigen/Core>

#include "datasets/rig/rigid_transform.h"
#include "datasets/rig/skeleton.h"
#include "evaluators/solvers/point_estimate.h"
#include "evaluators/solvers/range_problem.h"

namespace trilat {

// One joint as one sensor sees it at one instant. Lists of observations have one entry for each sensor of the
// rig, in its order, whether it sees the joint or not.
struct JointObservation {
  bool seen = false;
  TrackingState state = TrackingState::not_tracked;
  Eigen::Vector3d point_in_world_m = Eigen::Vector3d::Constant(kNaN);
  double range_m = kNaN;  // length of the joint's vector in the sensor's own frame (erratum E9)
};

// Seen when the state says so (inferred or tracked) and the point is finite.
JointObservation observe(const Eigen::Vector3d& point_in_sensor_m, TrackingState state,
                         const RigidTransform& world_from_sensor);

// The sensors of the rig that a method may use.
using SensorMask = std::bitset<kMaxSensors>;
inline constexpr SensorMask kAllSensors{(1u << kMaxSensors) - 1u};

// The ranges of the allowed sensors that see the joint, and as guess the mean of their points.
// InternalError when the two lists differ in length or exceed kMaxSensors.
RangeProblem ranges_of(std::span<const JointObservation> observations,
                       std::span<const RigidTransform> world_from_sensor, SensorMask allowed = kAllSensors);

}  // namespace trilat
