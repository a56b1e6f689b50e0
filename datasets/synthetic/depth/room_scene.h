// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "datasets/base/document.h"
#include "datasets/synthetic/motion.h"

namespace trilat {

// Scene of virtual depth sensors, in the world's frame, metres. The nearest surface along a ray is seen;
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

// The room about the middle of the rig: the floor y = 0 and up to four walls, in the order -z, -x, +x, +z.
struct RoomSpec {
  double half_width_m = 3.0;  // along x
  double half_depth_m = 3.0;  // along z
  int walls = 3;

  static void fields(auto& self, auto&& f) {
    f("half_width_m", self.half_width_m, opt("Distance from the centre to the side walls", {0.5, 100.0}));
    f("half_depth_m", self.half_depth_m, opt("Distance from the centre to the other walls", {0.5, 100.0}));
    f("walls", self.walls,
      opt("Number of walls, in the order -z, -x, +x, +z; the floor lies at y = 0", {0.0, 4.0}));
  }
};
void append_room(DepthScene& scene, const RoomSpec& room, const Eigen::Vector3d& centre_in_world_m);

// A part of a person's surface: a capsule about a bone, or, with both ends the same, a sphere about a joint.
struct BodySurface {
  Joint parent, end;
  double radius_m;
};
// A capsule for every bone whose ends are present and a sphere for the head.
std::vector<BodySurface> surfaces_of(const SkeletonPose& pose);
void append_person(DepthScene& scene, const SkeletonPose& pose);

// About how thick the body is at a joint.
double radius_at(Joint joint);

// A ball on a stick, which starts in the ball's centre.
struct WandShape {
  double ball_radius_m = 0.075;
  double stick_radius_m = 0.01;
  double stick_length_m = 1.2;
};
void append_wand(DepthScene& scene, const Eigen::Vector3d& ball_in_world_m,
                 const Eigen::Vector3d& stick_direction, const WandShape& shape);

}  // namespace trilat
