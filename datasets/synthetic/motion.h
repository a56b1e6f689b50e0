// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "datasets/rig/campaign.h"
#include "datasets/rig/skeleton.h"

namespace trilat {

// True positions of a person's joints at one instant, in the world, metres. Joints that the source of the
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

// A real OptiTrack take as a motion: each mapped joint is the mean of its assets, interpolated between
// samples at most 0.1 s apart and not present in longer gaps or frozen stretches. Time zero is the first
// frame of the export. InputError where no axis is stated and the person stands along z.
struct RecordedMotion {
  Motion motion;
  double duration_s = 0.0;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  // mean of all joint positions
  std::vector<Joint> joints;
};
RecordedMotion read_recorded_motion(const std::filesystem::path& mocap, const std::filesystem::path& mapping,
                                    std::optional<UpAxis> up_axis = {});

}  // namespace trilat
