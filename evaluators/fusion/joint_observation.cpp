// SPDX-License-Identifier: MIT
#include "evaluators/fusion/joint_observation.h"

#include "datasets/base/error.h"

namespace trilat {

JointObservation observe(const Eigen::Vector3d& point_in_sensor_m, TrackingState state,
                         const RigidTransform& world_from_sensor) {
  if (state == TrackingState::not_tracked || !point_in_sensor_m.allFinite()) return {};
  return {true, state, world_from_sensor * point_in_sensor_m, point_in_sensor_m.norm()};
}

RangeProblem ranges_of(std::span<const JointObservation> observations,
                       std::span<const RigidTransform> world_from_sensor, SensorMask allowed) {
  TRILAT_CHECK(observations.size() == world_from_sensor.size() && observations.size() <= kMaxSensors,
               "every sensor has one observation and one pose");
  RangeProblem problem;
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (!allowed[i] || !observations[i].seen) continue;
    problem.sensor_m[problem.count] = world_from_sensor[i].translation_m;
    problem.range_m[problem.count] = observations[i].range_m;
    problem.rig_index[problem.count] = static_cast<int>(i);
    sum_m += observations[i].point_in_world_m;
    ++problem.count;
  }
  if (problem.count > 0) problem.guess_m = sum_m / problem.count;
  return problem;
}

}  // namespace trilat
