// SPDX-License-Identifier: MIT
#include "datasets/synthetic/simulated_markers.h"

#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "datasets/base/philox.h"

namespace trilat {
namespace {

constexpr double kGapStretch_s = 0.2;
const Eigen::Vector3d kLost = Eigen::Vector3d::Constant(kNaN);

Eigen::Vector3d seen(const Eigen::Vector3d& marker_m, const MocapSpec& spec, const SimulatedItem& item,
                     std::uint64_t unit, std::uint64_t part, std::uint64_t frame) {
  const auto stretch =
      static_cast<std::uint64_t>(static_cast<double>(frame) / (spec.rate_hz * kGapStretch_s));
  const RandomStream gap{item.seed, Purpose::marker_gap, random_item(item.take, unit, part, stretch)};
  if (gap.uniform(0) < spec.gap_share) return kLost;
  const RandomStream noise{item.seed, Purpose::marker_noise, random_item(item.take, unit, part, frame)};
  const auto xy = noise.normal_pair(0);
  return marker_m + spec.marker_noise_sigma_m * Eigen::Vector3d(xy[0], xy[1], noise.normal(1));
}

}  // namespace

std::string marker_name(Joint joint, int marker) {
  return std::string(name_of(joint)) + "_" + std::to_string(marker + 1);
}

std::vector<Eigen::Vector3d> simulate_markers(const SkeletonPose& pose, Joint joint, const MocapSpec& spec,
                                              const SimulatedItem& item, std::uint64_t frame) {
  static const Eigen::Vector3d kCorners[kMarkersPerJoint] = {
      {1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  const Eigen::AngleAxisd turn(pose.heading_rad, Eigen::Vector3d::UnitY());
  std::vector<Eigen::Vector3d> markers;
  for (int m = 0; m < kMarkersPerJoint; ++m) {
    const auto part = static_cast<std::uint64_t>(joint);
    const auto unit = static_cast<std::uint64_t>(m);
    if (!pose.present[static_cast<std::size_t>(joint)]) {
      markers.push_back(kLost);
      continue;
    }
    const Eigen::Vector3d marker =
        pose.at(joint) + spec.marker_offset_m / std::sqrt(3.0) * (turn * kCorners[m]);
    markers.push_back(seen(marker, spec, item, unit, part, frame));
  }
  return markers;
}

Eigen::Vector3d simulate_rigid_body(const Eigen::Vector3d& position_in_world_m, const MocapSpec& spec,
                                    const SimulatedItem& item, std::uint64_t frame) {
  return seen(position_in_world_m, spec, item, 0, 0, frame);
}

Duration mocap_clock_error(const MocapSpec& spec, const SimulatedItem& item) {
  const RandomStream random{item.seed, Purpose::mocap_clock, item.take};
  return duration_from_s(random.uniform(0, -spec.clock_error_s, spec.clock_error_s));
}

}  // namespace trilat
