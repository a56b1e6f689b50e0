// SPDX-License-Identifier: MIT
#include "datasets/take/up_axis.h"

#include <algorithm>
#include <array>
#include <vector>

namespace trilat {
namespace {

constexpr double kShortest_m = 0.1;  // from the lowest level to the highest
constexpr double kLeastCosine = 0.8;

// What lies at one height of a person who stands, from the top. The arms may be anywhere.
using enum Joint;
const std::array<std::vector<Joint>, StandingAxis::kLevels> kJointsOfLevel{
    {{head},
     {neck, spine_shoulder, shoulder_left, shoulder_right},
     {spine_base, hip_left, hip_right},
     {knee_left, knee_right},
     {ankle_left, ankle_right, foot_left, foot_right}}};

}  // namespace

void StandingAxis::add(Joint joint, const Eigen::Vector3d& point_m) {
  if (!point_m.allFinite()) return;
  for (std::size_t level = 0; level < kLevels; ++level)
    if (std::ranges::find(kJointsOfLevel.at(level), joint) != kJointsOfLevel.at(level).end()) {
      levels_.at(level).sum_m += point_m;
      levels_.at(level).count += 1.0;
    }
}

std::optional<UpAxis> StandingAxis::axis() const {
  const auto is_known = [](const Level& level) { return level.count > 0.0; };
  const auto highest = std::ranges::find_if(levels_, is_known);
  const auto lowest = std::find_if(levels_.rbegin(), levels_.rend(), is_known);
  if (highest == levels_.end()) return std::nullopt;
  const Eigen::Vector3d up_m = highest->sum_m / highest->count - lowest->sum_m / lowest->count;
  if (!(up_m.norm() > kShortest_m)) return std::nullopt;
  if (up_m.y() > kLeastCosine * up_m.norm()) return UpAxis::y;
  if (up_m.z() > kLeastCosine * up_m.norm()) return UpAxis::z;
  return std::nullopt;
}

}  // namespace trilat
