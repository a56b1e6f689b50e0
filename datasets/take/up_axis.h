// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "datasets/skeleton/skeleton.h"

namespace trilat {

// Which axis of a ground truth's world points up. Ours is y; laboratories that write C3D or TRC often have z.
enum class UpAxis : std::uint8_t { automatic, y, z };
inline const std::array<std::string, 3> kUpAxisNames{"auto", "y", "z"};

// A point of a right-handed world with z up, in one with y up: a quarter turn about x.
inline Eigen::Vector3d y_up_from_z_up(const Eigen::Vector3d& point) {
  return {point.x(), point.z(), -point.y()};
}

// Along which axis a person stands: from the lowest joints that are known to the highest, in the mean.
class StandingAxis {
 public:
  static constexpr std::size_t kLevels = 5;  // head, shoulders, hips, knees, feet
  // Points that are not finite, and arms, say nothing.
  void add(Joint joint, const Eigen::Vector3d& point_m);
  // Nothing when neither axis is within 37 degrees, as of a person who lies, or too little is known.
  std::optional<UpAxis> axis() const;

 private:
  struct Level {
    Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
    double count = 0.0;
  };
  std::array<Level, kLevels> levels_;
};

}  // namespace trilat
