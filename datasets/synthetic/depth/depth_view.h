// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <vector>

#include "datasets/rig/depth_rays.h"
#include "datasets/rig/rigid_transform.h"
#include "datasets/synthetic/depth/room_scene.h"

namespace trilat {

// A rectangle of rays scaled to z = 1.
struct RayBox {
  double x_low, x_high, y_low, y_high;
};
// Columns and rows from first to last - 1.
struct PixelBox {
  int first_column, last_column, first_row, last_row;
};

using FloatVector3 = std::array<float, 3>;

// A scene as one sensor sees it, metres in the sensor's frame, made ready for casting. A plane's 1/depth
// along the ray (x, y, 1) is linear in x and y.
struct ViewPlane {
  float per_x, per_y, constant;  // of 1/depth
  float distance_m;              // of the lens from the plane
};
struct ViewSphere {
  FloatVector3 centre_m;
  float radius_m;
  RayBox box;
};
struct ViewCapsule {
  FloatVector3 from_m, axis_m, middle_m;  // axis: from one end to the other
  float axis_m2, radius_m;
  RayBox box;
};
struct DepthView {
  std::vector<ViewPlane> planes;
  std::vector<ViewSphere> spheres;
  std::vector<ViewCapsule> capsules;
};

// Rays that can meet balls about these centres, or what lies between two of them; in the sensor's frame.
RayBox box_of(std::initializer_list<Eigen::Vector3d> centres_m, double radius_m);

// Leaves out what cannot be seen: planes from behind, things wholly behind the lens. A capsule without length
// becomes a sphere.
DepthView depth_view(const DepthScene& scene, const RigidTransform& world_from_sensor);

// Which pixels can have a ray in a box, whatever the lens does: every column knows the least and the largest
// x of its rays, every row those of its y.
class PixelBoxFinder {
 public:
  explicit PixelBoxFinder(const DepthRays& rays);
  // The box grown by `margin` (of rays at z = 1) on every side; may be empty.
  PixelBox pixels_of(const RayBox& box, double margin) const;

 private:
  struct Interval {
    float low, high;
  };
  std::vector<Interval> column_x_, row_y_;
};

}  // namespace trilat
