// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <functional>

#include <Eigen/Core>

#include "datasets/skeleton/skeleton.h"

namespace trilat {

// Where a person's joints truly are at one instant, in the world, metres. Joints that the source of the
// motion does not know are not present. `heading_rad` turns the body's forward from world +z towards +x.
struct SkeletonPose {
  std::array<Eigen::Vector3d, kJointCount> joint_in_world_m;
  std::bitset<kJointCount> present;
  double heading_rad = 0.0;

  SkeletonPose() { joint_in_world_m.fill(Eigen::Vector3d::Zero()); }
  Eigen::Vector3d& at(Joint joint) { return joint_in_world_m[static_cast<std::size_t>(joint)]; }
  const Eigen::Vector3d& at(Joint joint) const { return joint_in_world_m[static_cast<std::size_t>(joint)]; }
};

// A motion is a function of the time since its start, in seconds; it may be asked at any time and in any
// order.
using Motion = std::function<SkeletonPose(double time_s)>;

}  // namespace trilat
