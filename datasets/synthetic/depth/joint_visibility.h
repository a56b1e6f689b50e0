// SPDX-License-Identifier: MIT
#pragma once

#include <bitset>
#include <optional>
#include <vector>

#include "datasets/rig/depth_camera.h"
#include "datasets/rig/rigid_transform.h"
#include "datasets/synthetic/depth/depth_view.h"
#include "datasets/synthetic/motion.h"

namespace trilat {

// Which joints a depth sensor can see: it looks along a few pixels about each joint, at the same surfaces
// that append_person() gives the depth renderer, and asks whose is the first. One object a sensor and thread:
// it keeps the rays of pixels it was asked for.
//
// A joint's own surfaces are the bones that end or start at it; for the head and the neck also the head's
// sphere; for the wrist, hand, hand tip and thumb of one side all bones between them; for shoulders, hips and
// neck also the piece of the spine that their bone comes from, for the neck also the bones to the shoulders.
// An own surface that is met more than its diameter before the joint hides it like any other: the far
// shoulder is behind the chest, and an elbow behind the hand that points at the lens. (Not the neck, which
// stands above the shoulders whatever the side.)
class JointVisibility {
 public:
  explicit JointVisibility(const DepthIntrinsics& intrinsics);

  // The person whom the sensor sees from now on. Joints may lie outside of the image.
  void set_person(const SkeletonPose& pose, const RigidTransform& world_from_sensor);

  // Depth of the person's nearest surface along a pixel's ray; nothing where there is none.
  std::optional<double> depth_m(int column, int row);

  // Share of the pixels about a joint that meet its own surfaces and nothing else 1 mm before:
  // the middle and four about it, half of the limb's radius across and down: a thin limb in front covers few.
  // 1 when none of them meets an own surface.
  double visible_share(Joint joint);

  // Joints with a smaller visible share than that; 0 hides none.
  std::bitset<kJointCount> hidden_joints(double least_visible_share);

 private:
  struct Ray {
    float x, y;
  };
  struct Surface {
    Eigen::Vector3d from_m, axis_m;
    double axis_m2, radius_m;
    RayBox box;  // no ray outside meets it
    std::bitset<kJointCount> owners;
  };
  Ray ray_of(int column, int row);
  void add_surface(const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m, double radius_m,
                   std::bitset<kJointCount> owners);
  // The nearest depth of all surfaces and of one joint's own, infinite where none is met.
  struct Nearest {
    double any_m, own_m;
  };
  Nearest nearest(int column, int row, Joint joint);

  DepthIntrinsics intrinsics_;
  std::vector<Ray> rays_;  // NaN until asked for
  SkeletonPose in_sensor_;
  std::vector<Surface> surfaces_;
};

}  // namespace trilat
