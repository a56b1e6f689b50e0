// SPDX-License-Identifier: MIT
#include "datasets/synthetic/depth/depth_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace trilat {
namespace {

using Eigen::Vector3d;

constexpr double kEverywhere = 1e9;
constexpr double kNoAxis_m = 1e-6;

FloatVector3 floats_of(const Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

// The tangents of a circle about (side, z) from the origin, as side / z.
void include_silhouette(double side_m, double z_m, double radius_m, double& low, double& high) {
  const double distance_m = std::hypot(side_m, z_m);
  const double middle = std::atan2(side_m, z_m);
  const double half =
      radius_m < distance_m ? std::asin(radius_m / distance_m) : std::numbers::pi;  // inside: everything
  const auto bound = [](double angle) {
    return std::abs(angle) < 0.499 * std::numbers::pi ? std::tan(angle) : std::copysign(kEverywhere, angle);
  };
  low = std::min(low, bound(middle - half));
  high = std::max(high, bound(middle + half));
}

}  // namespace

// The outline of a capsule is the hull of its end spheres' while both are in front of the lens; otherwise it
// may be anywhere.
RayBox box_of(std::initializer_list<Vector3d> centres_m, double radius_m) {
  RayBox box{kEverywhere, -kEverywhere, kEverywhere, -kEverywhere};
  for (const Vector3d& centre : centres_m) {
    if (centre.z() <= radius_m) return {-kEverywhere, kEverywhere, -kEverywhere, kEverywhere};
    include_silhouette(centre.x(), centre.z(), radius_m, box.x_low, box.x_high);
    include_silhouette(centre.y(), centre.z(), radius_m, box.y_low, box.y_high);
  }
  return box;
}

namespace {

void add_sphere(DepthView& view, const Vector3d& centre_m, double radius_m) {
  if (centre_m.z() + radius_m > 0.0)
    view.spheres.push_back({floats_of(centre_m), static_cast<float>(radius_m), box_of({centre_m}, radius_m)});
}

void add_capsule(DepthView& view, const Vector3d& from_m, const Vector3d& to_m, double radius_m) {
  const Vector3d axis_m = to_m - from_m;
  if (axis_m.norm() < kNoAxis_m) return add_sphere(view, from_m, radius_m);
  if (std::max(from_m.z(), to_m.z()) + radius_m > 0.0)
    view.capsules.push_back({floats_of(from_m), floats_of(axis_m), floats_of(0.5 * (from_m + to_m)),
                             static_cast<float>(axis_m.squaredNorm()), static_cast<float>(radius_m),
                             box_of({from_m, to_m}, radius_m)});
}

}  // namespace

DepthView depth_view(const DepthScene& scene, const RigidTransform& world_from_sensor) {
  const RigidTransform sensor_from_world = world_from_sensor.inverse();
  DepthView view;
  for (const ScenePlane& plane : scene.planes) {
    const double distance_m = plane.normal.dot(world_from_sensor.translation_m) - plane.offset_m;
    if (!(distance_m > 0.0)) continue;
    const Vector3d per = sensor_from_world.rotation * plane.normal / -distance_m;
    const FloatVector3 f = floats_of(per);
    view.planes.push_back({f[0], f[1], f[2], static_cast<float>(distance_m)});
  }
  for (const SceneSphere& sphere : scene.spheres)
    add_sphere(view, sensor_from_world * sphere.centre_m, sphere.radius_m);
  for (const SceneCapsule& capsule : scene.capsules)
    add_capsule(view, sensor_from_world * capsule.from_m, sensor_from_world * capsule.to_m, capsule.radius_m);
  return view;
}

PixelBoxFinder::PixelBoxFinder(const DepthRays& rays)
    : column_x_(static_cast<std::size_t>(rays.intrinsics.width_px),
                {std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()}),
      row_y_(static_cast<std::size_t>(rays.intrinsics.height_px), column_x_.front()) {
  const auto include = [](Interval& interval, float value) {
    if (value < interval.low) interval.low = value;  // false for NaN
    if (value > interval.high) interval.high = value;
  };
  for (std::size_t row = 0; row < row_y_.size(); ++row)
    for (std::size_t column = 0; column < column_x_.size(); ++column) {
      include(column_x_[column], rays.x[row * column_x_.size() + column]);
      include(row_y_[row], rays.y[row * column_x_.size() + column]);
    }
}

PixelBox PixelBoxFinder::pixels_of(const RayBox& box, double margin) const {
  constexpr double kRounding = 1e-5;  // of rays kept as floats
  const auto overlapping = [&](const std::vector<Interval>& intervals, double low, double high, int& first,
                               int& last) {
    first = last = 0;
    for (std::size_t i = 0; i < intervals.size(); ++i) {
      if (!(static_cast<double>(intervals[i].high) >= low - margin - kRounding &&
            static_cast<double>(intervals[i].low) <= high + margin + kRounding))
        continue;
      if (last == 0) first = static_cast<int>(i);
      last = static_cast<int>(i) + 1;
    }
  };
  PixelBox pixels{};
  overlapping(column_x_, box.x_low, box.x_high, pixels.first_column, pixels.last_column);
  overlapping(row_y_, box.y_low, box.y_high, pixels.first_row, pixels.last_row);
  return pixels;
}

}  // namespace trilat
