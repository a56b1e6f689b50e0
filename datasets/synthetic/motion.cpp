// SPDX-License-Identifier: MIT
#include "datasets/synthetic/motion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <set>

#include "datasets/base/error.h"
#include "datasets/mocap/read_mocap.h"
#include "datasets/rig/campaign.h"

namespace trilat {
namespace {

constexpr double kMaxGap_s = 0.105;

struct MappedJoint {
  Joint joint;
  std::vector<std::size_t> assets;
};

// The frames of the take in which a joint is whole.
struct JointTrack {
  Joint joint;
  std::vector<double> time_s;
  std::vector<Eigen::Vector3d> point_m;
};

std::vector<MappedJoint> resolve(const MocapHeader& header, const std::filesystem::path& mapping) {
  std::vector<MappedJoint> joints;
  for (const auto& entry : read_mapping(mapping).joints)
    joints.push_back(
        {entry.joint, assets_of_joint(header, entry.assets,
                                      mapping.string() + " /joints/" + std::string(name_of(entry.joint)))});
  return joints;
}

Eigen::Vector3d mean_of(const MocapTake& mocap, std::size_t frame, const std::vector<std::size_t>& assets) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t asset : assets) sum += mocap.position_m[asset][frame];  // NaN when one is missing
  return sum / static_cast<double>(assets.size());
}

Eigen::Vector3d point_at(const JointTrack& track, double t) {
  const Eigen::Vector3d none = Eigen::Vector3d::Constant(kNaN);
  const auto later = std::ranges::lower_bound(track.time_s, t);
  if (later == track.time_s.end()) return none;
  const auto b = static_cast<std::size_t>(later - track.time_s.begin());
  if (track.time_s[b] == t) return track.point_m[b];
  if (b == 0 || track.time_s[b] - track.time_s[b - 1] > kMaxGap_s) return none;
  const double share = (t - track.time_s[b - 1]) / (track.time_s[b] - track.time_s[b - 1]);
  return track.point_m[b - 1] + share * (track.point_m[b] - track.point_m[b - 1]);
}

}  // namespace

RecordedMotion read_recorded_motion(const std::filesystem::path& mocap, const std::filesystem::path& mapping,
                                    std::optional<UpAxis> up_axis) {
  const auto joints = resolve(read_mocap_header(mocap), mapping);
  auto tracks = std::make_shared<std::vector<JointTrack>>();
  for (const MappedJoint& mapped : joints) tracks->push_back({mapped.joint, {}, {}});
  RecordedMotion result;
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  double points = 0.0;
  UpAxisEstimator standing;
  std::set<std::size_t> wanted;
  for (const MappedJoint& mapped : joints) wanted.insert(mapped.assets.begin(), mapped.assets.end());
  const MocapTake positions = read_positions(mocap, {.assets = {{wanted.begin(), wanted.end()}}});
  for (std::size_t frame = 0; frame < positions.time.size(); ++frame) {
    const double t = positions.time[frame].ns * 1e-9;
    result.duration_s = t;
    for (std::size_t j = 0; j < joints.size(); ++j) {
      const Eigen::Vector3d point = mean_of(positions, frame, joints[j].assets);
      if (!point.allFinite()) continue;
      (*tracks)[j].time_s.push_back(t);
      (*tracks)[j].point_m.push_back(point);
      standing.add(joints[j].joint, point);
      sum_m += point;
      ++points;
    }
  }
  if (points == 0.0) throw InputError(mocap.string(), "never holds any of the mapped joints whole");
  result.centre_m = sum_m / points;
  if (!up_axis && standing.axis() == UpAxis::z) throw InputError(mocap.string(), kStandsAlongZ);
  if (up_axis == UpAxis::z) {
    result.centre_m = y_up_from_z_up(result.centre_m);
    for (JointTrack& track : *tracks)
      for (Eigen::Vector3d& point : track.point_m) point = y_up_from_z_up(point);
  }
  for (const MappedJoint& mapped : joints) result.joints.push_back(mapped.joint);
  result.motion = [tracks](double t) {
    SkeletonPose pose;
    for (const JointTrack& track : *tracks) {
      const Eigen::Vector3d point = point_at(track, t);
      if (!point.allFinite()) continue;
      pose.at(track.joint) = point;
      pose.present.set(static_cast<std::size_t>(track.joint));
    }
    return pose;
  };
  return result;
}

}  // namespace trilat
