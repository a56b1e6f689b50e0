// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "datasets/synthetic/motion.h"

namespace trilat {

// A real OptiTrack take as a motion: each mapped joint is the mean of its assets, interpolated between
// samples at most 0.1 s apart and not present in longer gaps or frozen stretches. Time zero is the first
// frame of the export.
struct RecordedMotion {
  Motion motion;
  double duration_s = 0.0;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  // mean of all joint positions
  std::vector<Joint> joints;
};
RecordedMotion read_recorded_motion(const std::filesystem::path& mocap, const std::filesystem::path& mapping);

}  // namespace trilat
