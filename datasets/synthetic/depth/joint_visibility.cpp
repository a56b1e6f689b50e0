// SPDX-License-Identifier: MIT
#include "datasets/synthetic/depth/joint_visibility.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "datasets/synthetic/depth/room_scene.h"

namespace trilat {
namespace {

using Eigen::Vector3d;
using Joints = std::bitset<kJointCount>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kOffset = 0.5;  // of the limb's radius, across and down from the middle pixel
constexpr double kNoLength_m = 1e-6;
constexpr double kSame_m = 1e-3;  // a depth image shows no smaller difference

Joints joints_of(std::initializer_list<Joint> list) {
  Joints joints;
  for (const Joint joint : list) joints.set(static_cast<std::size_t>(joint));
  return joints;
}

// Joints that a bone's surface belongs to: it does not hide them.
Joints owners_of(Joint parent, Joint end) {
  using enum Joint;
  static const Joints hands[] = {joints_of({wrist_left, hand_left, hand_tip_left, thumb_left}),
                                 joints_of({wrist_right, hand_right, hand_tip_right, thumb_right})};
  Joints owners = joints_of({parent, end});
  if (parent == end) owners |= joints_of({head, neck});
  for (const Joints& hand : hands)
    if (hand[static_cast<std::size_t>(parent)] && hand[static_cast<std::size_t>(end)]) owners |= hand;
  if (end == spine_mid) owners |= joints_of({hip_left, hip_right});
  if (end == spine_shoulder) owners |= joints_of({shoulder_left, shoulder_right, neck});
  if (parent == spine_shoulder) owners |= joints_of({neck});
  return owners;
}

// Depth at which a ray from the lens enters the ball about `centre_m`; infinite when it does not.
double intersect_sphere(const Vector3d& ray, double ray2, const Vector3d& centre_m, double radius_m) {
  const double closest = ray.dot(centre_m) / ray2;
  const double inside = radius_m * radius_m - (closest * ray - centre_m).squaredNorm();
  return inside > 0.0 ? closest - std::sqrt(inside / ray2) : kInfinity;
}

// The infinite cylinder first; where that is met beyond an end of the axis, the ball at that end.
double intersect_capsule(const Vector3d& ray, double ray2, const Vector3d& from_m, const Vector3d& axis_m,
                         double axis_m2, double radius_m) {
  if (axis_m2 == 0.0) return intersect_sphere(ray, ray2, from_m, radius_m);
  const double axis_ray = axis_m.dot(ray), axis_from = axis_m.dot(from_m);
  const double a = axis_m2 * ray2 - axis_ray * axis_ray;
  double height = -axis_ray;  // of a ray along the axis: the end that it comes to first
  if (a > 1e-12 * axis_m2 * ray2) {
    const double b = axis_ray * axis_from - axis_m2 * ray.dot(from_m);
    const double c = axis_m2 * (from_m.squaredNorm() - radius_m * radius_m) - axis_from * axis_from;
    const double h = b * b - a * c;
    if (h <= 0.0) return kInfinity;
    const double depth_m = (-b - std::sqrt(h)) / a;
    height = depth_m * axis_ray - axis_from;
    if (height > 0.0 && height < axis_m2) return depth_m;
  }
  return intersect_sphere(ray, ray2, height <= 0.0 ? from_m : Vector3d(from_m + axis_m), radius_m);
}

}  // namespace

JointVisibility::JointVisibility(const DepthIntrinsics& intrinsics)
    : intrinsics_(intrinsics),
      rays_(static_cast<std::size_t>(intrinsics.width_px) * static_cast<std::size_t>(intrinsics.height_px),
            {std::numeric_limits<float>::quiet_NaN(), 0.0f}) {}

void JointVisibility::add_surface(const Vector3d& from_m, const Vector3d& to_m, double radius_m,
                                  Joints owners) {
  if (std::max(from_m.z(), to_m.z()) + radius_m <= 0.0) return;  // behind the lens
  const bool ball = (to_m - from_m).norm() < kNoLength_m;
  Surface s{from_m,
            ball ? Vector3d::Zero() : Vector3d(to_m - from_m),
            0.0,
            radius_m,
            box_of({from_m, to_m}, radius_m),
            owners};
  s.axis_m2 = s.axis_m.squaredNorm();
  surfaces_.push_back(s);
}

void JointVisibility::set_person(const SkeletonPose& pose, const RigidTransform& world_from_sensor) {
  const RigidTransform sensor_from_world = world_from_sensor.inverse();
  in_sensor_ = pose;
  surfaces_.clear();
  for (Vector3d& joint : in_sensor_.joint_in_world_m) joint = sensor_from_world * joint;
  for (const BodySurface& part : surfaces_of(in_sensor_))
    add_surface(in_sensor_.at(part.parent), in_sensor_.at(part.end), part.radius_m,
                owners_of(part.parent, part.end));
}

JointVisibility::Ray JointVisibility::ray_of(int column, int row) {
  Ray& ray = rays_[static_cast<std::size_t>(row) * static_cast<std::size_t>(intrinsics_.width_px) +
                   static_cast<std::size_t>(column)];
  if (std::isnan(ray.x)) {
    const auto found = ray_through(intrinsics_, {column, row});
    constexpr float kNowhere = std::numeric_limits<float>::infinity();  // where the lens has no inverse
    ray =
        found ? Ray{static_cast<float>(found->x()), static_cast<float>(found->y())} : Ray{kNowhere, kNowhere};
  }
  return ray;
}

JointVisibility::Nearest JointVisibility::nearest(int column, int row, Joint joint) {
  const Ray pixel = ray_of(column, row);
  const double x = static_cast<double>(pixel.x), y = static_cast<double>(pixel.y);
  Nearest found{kInfinity, kInfinity};
  if (!std::isfinite(x)) return found;
  const Vector3d ray(x, y, 1.0);
  const double ray2 = ray.squaredNorm();
  for (const Surface& s : surfaces_) {
    if (!(x > s.box.x_low && x < s.box.x_high && y > s.box.y_low && y < s.box.y_high)) continue;
    const double depth = intersect_capsule(ray, ray2, s.from_m, s.axis_m, s.axis_m2, s.radius_m);
    if (!(depth > 0.0)) continue;
    found.any_m = std::min(found.any_m, depth);
    const double joint_m = in_sensor_.at(joint).z();
    if (s.owners[static_cast<std::size_t>(joint)] &&
        (joint == Joint::neck || depth >= joint_m - 2.0 * s.radius_m))
      found.own_m = std::min(found.own_m, depth);
  }
  return found;
}

std::optional<double> JointVisibility::depth_m(int column, int row) {
  const double depth = nearest(column, row, Joint::head).any_m;
  return std::isfinite(depth) ? std::optional(depth) : std::nullopt;
}

double JointVisibility::visible_share(Joint joint) {
  const Vector3d& at = in_sensor_.at(joint);
  const auto pixel = project(intrinsics_, at);
  if (!pixel) return 1.0;
  const int column = static_cast<int>(std::lround(pixel->x())),
            row = static_cast<int>(std::lround(pixel->y()));
  const int away =
      std::max(1, static_cast<int>(std::lround(kOffset * radius_at(joint) * intrinsics_.fx_px / at.z())));
  const std::array<std::array<int, 2>, 5> pixels{{{column, row},
                                                  {column - away, row - away},
                                                  {column + away, row - away},
                                                  {column - away, row + away},
                                                  {column + away, row + away}}};
  int own = 0, first = 0;
  for (const auto& [c, r] : pixels) {
    if (c < 0 || r < 0 || c >= intrinsics_.width_px || r >= intrinsics_.height_px) continue;
    const Nearest found = nearest(c, r, joint);
    if (!std::isfinite(found.own_m)) continue;
    ++own;
    if (found.own_m <= found.any_m + kSame_m) ++first;
  }
  return own > 0 ? static_cast<double>(first) / own : 1.0;
}

Joints JointVisibility::hidden_joints(double least_visible_share) {
  Joints hidden;
  for (std::size_t j = 0; j < kJointCount; ++j)
    hidden[j] = least_visible_share > 0.0 && in_sensor_.present[j] &&
                visible_share(static_cast<Joint>(j)) < least_visible_share;
  return hidden;
}

}  // namespace trilat
