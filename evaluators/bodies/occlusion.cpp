// SPDX-License-Identifier: MIT
#include "evaluators/bodies/occlusion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "datasets/base/error.h"

namespace trilat {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// A bone's ends in the plane where crossings are looked for, with a depth that is linear along the bone there
// and larger where it is farther away.
struct Segment {
  Bone bone;
  std::array<Vector2d, 2> end;
  std::array<double, 2> depth;
};

struct SegmentEnd {
  Vector2d place;
  double depth;
};

SegmentEnd end_of(const Vector3d& joint_m, OcclusionVariant variant) {
  if (variant == OcclusionVariant::printed) return {joint_m.head<2>(), joint_m.z()};
  // In the image 1 / z, not z, is linear along a straight bone.
  return {joint_m.head<2>() / joint_m.z(), -1.0 / joint_m.z()};
}

struct Segments {
  std::array<Segment, kBoneCount> segment;
  std::size_t count = 0;
};

Segments segments_of(const ObservedBody& body, OcclusionVariant variant) {
  const auto usable = [&](Joint joint) {
    return body.has(joint) && (variant == OcclusionVariant::printed || body.at(joint).z() > 0.0);
  };
  Segments segments;
  for (const Bone& bone : kBones) {
    if (!usable(bone.parent) || !usable(bone.child)) continue;
    const SegmentEnd a = end_of(body.at(bone.parent), variant), b = end_of(body.at(bone.child), variant);
    segments.segment[segments.count++] = {bone, {a.place, b.place}, {a.depth, b.depth}};
  }
  return segments;
}

bool share_a_joint(const Bone& a, const Bone& b) {
  return a.parent == b.parent || a.parent == b.child || a.child == b.parent || a.child == b.child;
}

double vector_product(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

// The first four conditions of equation 8.
bool boxes_meet(const Segment& a, const Segment& b) {
  for (int axis = 0; axis < 2; ++axis) {
    if (std::min(a.end[0][axis], a.end[1][axis]) > std::max(b.end[0][axis], b.end[1][axis])) return false;
    if (std::min(b.end[0][axis], b.end[1][axis]) > std::max(a.end[0][axis], a.end[1][axis])) return false;
  }
  return true;
}

// Share at which the line of `b` divides `a`, from 0 to 1; NaN unless the ends of `a` are on different sides
// of it.
double crossing_on(const Segment& a, const Segment& b) {
  const Vector2d along = b.end[1] - b.end[0];
  const double first = vector_product(a.end[0] - b.end[0], along);
  const double second = vector_product(a.end[1] - b.end[0], along);
  const bool on_both_sides = (first < 0.0 && second > 0.0) || (first > 0.0 && second < 0.0);
  return on_both_sides ? first / (first - second) : kNaN;
}

double depth_at(const Segment& segment, double part) {
  return (1.0 - part) * segment.depth[0] + part * segment.depth[1];
}

}  // namespace

std::array<int, kJointCount> count_occlusions(const ObservedBody& body, OcclusionVariant variant) {
  std::array<int, kJointCount> occlusions{};
  const Segments all = segments_of(body, variant);
  for (std::size_t i = 0; i < all.count; ++i) {
    for (std::size_t j = i + 1; j < all.count; ++j) {
      const Segment &a = all.segment[i], &b = all.segment[j];
      if (variant == OcclusionVariant::corrected && share_a_joint(a.bone, b.bone)) continue;
      if (!boxes_meet(a, b)) continue;
      const double on_a = crossing_on(a, b), on_b = crossing_on(b, a);
      if (std::isnan(on_a) || std::isnan(on_b)) continue;
      const double depth_a = depth_at(a, on_a), depth_b = depth_at(b, on_b);
      if (depth_a == depth_b) continue;
      const Bone& behind = depth_a > depth_b ? a.bone : b.bone;
      ++occlusions[static_cast<std::size_t>(behind.parent)];
      ++occlusions[static_cast<std::size_t>(behind.child)];
    }
  }
  return occlusions;
}

SensorMask select_unoccluded(std::span<const int> occlusions_of_sensor, SensorMask seen, int fewest) {
  TRILAT_CHECK(occlusions_of_sensor.size() <= kMaxSensors, "the rig is within the capacity");
  std::vector<int> counts;
  for (std::size_t i = 0; i < occlusions_of_sensor.size(); ++i)
    if (seen[i]) counts.push_back(occlusions_of_sensor[i]);
  SensorMask selected;
  if (counts.empty()) return selected;
  std::ranges::sort(counts);
  const auto wanted = static_cast<std::size_t>(std::max(1, fewest));
  const int most = counts[std::min(wanted, counts.size()) - 1];
  for (std::size_t i = 0; i < occlusions_of_sensor.size(); ++i)
    selected[i] = seen[i] && occlusions_of_sensor[i] <= most;
  return selected;
}

}  // namespace trilat
