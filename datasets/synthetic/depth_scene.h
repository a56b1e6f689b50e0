// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

namespace trilat {

// What virtual depth sensors look at, in the world's frame, metres. The nearest surface along a ray is seen;
// nothing there (or nothing in range) is an invalid pixel.
struct ScenePlane {  // unit normal, towards the side that is seen from; normal . x = offset
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();
  double offset_m = 0.0;
};
struct SceneSphere {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  double radius_m = 0.0;
};
struct SceneCapsule {  // all points within radius of the segment
  Eigen::Vector3d from_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d to_m = Eigen::Vector3d::Zero();
  double radius_m = 0.0;
};
struct DepthScene {
  std::vector<ScenePlane> planes;
  std::vector<SceneSphere> spheres;
  std::vector<SceneCapsule> capsules;
};

}  // namespace trilat
