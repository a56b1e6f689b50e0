// SPDX-License-Identifier: MIT
// Joints of which each sensor of a rig gives a position that is off along and across its ray.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "datasets/base/philox.h"
#include "evaluators/fusion/joint_observation.h"
#include "evaluators/fusion/range_bearing.h"

namespace trilat {

inline Eigen::Vector3d normal_vector_of(const RandomStream& random, std::uint32_t first) {
  return {random.normal(first), random.normal(first + 1), random.normal(first + 2)};
}

// Sensors on a circle about the origin, at these heights, over an arc of so many degrees.
inline std::vector<RigidTransform> circle_rig(const std::vector<double>& heights_m, double radius_m = 2.0,
                                              double arc_deg = 360.0) {
  std::vector<RigidTransform> rig(heights_m.size());
  const double step = arc_deg / 180.0 * std::numbers::pi / static_cast<double>(heights_m.size());
  for (std::size_t i = 0; i < rig.size(); ++i) {
    const double angle = step * static_cast<double>(i);
    rig[i].translation_m = {radius_m * std::sin(angle), heights_m[i], radius_m * std::cos(angle)};
  }
  return rig;
}

// Sigmas whose squares sum to total_m^2 over the three directions, range : bearing as `ratio`.
inline RaySigma sigmas_of(double ratio, double total_m) {
  const double bearing_m = total_m / std::sqrt(ratio * ratio + 2.0);
  return {ratio * bearing_m, bearing_m};
}

// A joint as a sensor sees it: `error` is standard normal along the ray and in two directions across it.
inline JointObservation seen_from(const RigidTransform& sensor, const Eigen::Vector3d& joint_m,
                                  const RaySigma& sigma, const Eigen::Vector3d& error) {
  const Eigen::Vector3d ray_m = joint_m - sensor.translation_m, u = ray_m.normalized();
  const Eigen::Vector3d side = u.unitOrthogonal(), up = u.cross(side);
  const double range_m = ray_m.norm() + sigma.range_m * error[0];
  const Eigen::Vector3d direction =
      (ray_m + sigma.bearing_m * (error[1] * side + error[2] * up)).normalized();
  return {true, TrackingState::tracked, sensor.translation_m + range_m * direction, range_m};
}

inline std::vector<JointObservation> seen_from(const std::vector<RigidTransform>& rig,
                                               const Eigen::Vector3d& joint_m, const RaySigma& sigma,
                                               const RandomStream& random) {
  std::vector<JointObservation> seen;
  for (std::size_t i = 0; i < rig.size(); ++i)
    seen.push_back(
        seen_from(rig[i], joint_m, sigma, normal_vector_of(random, static_cast<std::uint32_t>(16 + 3 * i))));
  return seen;
}

// Uniform in the box where a person's joints are.
inline Eigen::Vector3d some_joint_m(const RandomStream& random) {
  return {random.uniform(0) - 0.5, 0.2 + 1.6 * random.uniform(1), random.uniform(2) - 0.5};
}

}  // namespace trilat
