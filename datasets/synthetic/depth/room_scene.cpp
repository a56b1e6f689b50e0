// SPDX-License-Identifier: MIT
#include "datasets/synthetic/depth/room_scene.h"

#include "datasets/base/error.h"

namespace trilat {
namespace {

using Eigen::Vector3d;

constexpr double kHeadRadius_m = 0.10;

// Radius of a limb of normal build with clothes on; the bone is named by its end away from the pelvis.
double bone_radius_m(Joint end) {
  switch (end) {
    case Joint::spine_mid:
    case Joint::spine_shoulder:
      return 0.14;
    case Joint::hip_left:
    case Joint::hip_right:
      return 0.10;
    case Joint::knee_left:
    case Joint::knee_right:
      return 0.075;
    case Joint::ankle_left:
    case Joint::ankle_right:
      return 0.05;
    case Joint::shoulder_left:
    case Joint::shoulder_right:
      return 0.07;
    case Joint::neck:
    case Joint::head:
      return 0.06;
    case Joint::elbow_left:
    case Joint::elbow_right:
      return 0.045;
    case Joint::thumb_left:
    case Joint::thumb_right:
    case Joint::hand_tip_left:
    case Joint::hand_tip_right:
      return 0.02;
    case Joint::wrist_left:
    case Joint::wrist_right:
    case Joint::hand_left:
    case Joint::hand_right:
    case Joint::foot_left:
    case Joint::foot_right:
    case Joint::spine_base:  // the root ends no bone
      return 0.035;
  }
  TRILAT_CHECK(false, "every joint has a radius");
}

}  // namespace

void append_room(DepthScene& scene, const RoomSpec& room, const Vector3d& centre_in_world_m) {
  scene.planes.push_back({Vector3d::UnitY(), 0.0});
  const Vector3d inwards[] = {Vector3d::UnitZ(), Vector3d::UnitX(), -Vector3d::UnitX(), -Vector3d::UnitZ()};
  for (int wall = 0; wall < room.walls; ++wall) {
    const Vector3d& normal = inwards[wall];
    const double half_m = normal.x() == 0.0 ? room.half_depth_m : room.half_width_m;
    scene.planes.push_back({normal, normal.dot(centre_in_world_m) - half_m});
  }
}

std::vector<BodySurface> surfaces_of(const SkeletonPose& pose) {
  std::vector<BodySurface> surfaces;
  surfaces.reserve(kJointCount);
  for (const Joint end : kJointsRootFirst) {
    const auto parent = parent_of(end);
    if (parent && pose.present[static_cast<std::size_t>(end)] &&
        pose.present[static_cast<std::size_t>(*parent)])
      surfaces.push_back({*parent, end, bone_radius_m(end)});
  }
  if (pose.present[static_cast<std::size_t>(Joint::head)])
    surfaces.push_back({Joint::head, Joint::head, kHeadRadius_m});
  return surfaces;
}

void append_person(DepthScene& scene, const SkeletonPose& pose) {
  for (const BodySurface& part : surfaces_of(pose))
    if (part.parent == part.end)
      scene.spheres.push_back({pose.at(part.end), part.radius_m});
    else
      scene.capsules.push_back({pose.at(part.parent), pose.at(part.end), part.radius_m});
}

double radius_at(Joint joint) {
  return joint == Joint::head ? kHeadRadius_m
                              : bone_radius_m(joint == Joint::spine_base ? Joint::spine_mid : joint);
}

void append_wand(DepthScene& scene, const Vector3d& ball_in_world_m, const Vector3d& stick_direction,
                 const WandShape& shape) {
  scene.spheres.push_back({ball_in_world_m, shape.ball_radius_m});
  scene.capsules.push_back({ball_in_world_m,
                            ball_in_world_m + shape.stick_length_m * stick_direction.normalized(),
                            shape.stick_radius_m});
}

}  // namespace trilat
