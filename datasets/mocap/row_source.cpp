// SPDX-License-Identifier: MIT
#include "datasets/mocap/row_source.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "datasets/base/check.h"
#include "datasets/base/units.h"

namespace trilat {
namespace {

constexpr double kQuaternionTolerance = 1e-3;
constexpr std::int64_t kMicrohertz = 1'000'000;
constexpr std::int64_t kHighestRate_uhz = 9000 * kMicrohertz;
constexpr std::int64_t kMostFrames = 2'000'000'000;

}  // namespace

Eigen::Quaterniond rotation_from_printed(double x, double y, double z, double w) {
  const double length = std::sqrt(x * x + y * y + z * z + w * w);
  if (!(std::abs(length - 1.0) < kQuaternionTolerance)) return MocapPose().rotation;
  const double scale = 1.0 / length;
  return {w * scale, x * scale, y * scale, z * scale};
}

bool is_euler_order(std::string_view text) {
  std::string letters(text);
  std::ranges::sort(letters);
  return letters == "XYZ";
}

Eigen::Quaterniond rotation_from_euler(double x_deg, double y_deg, double z_deg, std::string_view order) {
  const std::array<double, 3> angles_deg{x_deg, y_deg, z_deg};
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  for (char letter : order) {
    const int axis = letter - 'X';
    rotation = rotation *
               Eigen::Quaterniond(Eigen::AngleAxisd(
                   angles_deg[static_cast<std::size_t>(axis)] * kRadPerDegree, Eigen::Vector3d::Unit(axis)));
  }
  return rotation;
}

void make_right_handed(MocapPose& pose) {
  pose.position_m.z() = -pose.position_m.z();
  pose.rotation.x() = -pose.rotation.x();
  pose.rotation.y() = -pose.rotation.y();
}

Duration duration_of_frames(std::int64_t frames, std::int64_t rate_uhz) {
  TRILAT_CHECK(rate_uhz >= kMicrohertz && rate_uhz <= kHighestRate_uhz, "the rate is in range");
  TRILAT_CHECK(frames >= 0 && frames <= kMostFrames, "the frame count is in range");
  // 2e9 s, and a remainder below 9e9, times 1e9 still fit.
  const std::int64_t ticks = frames * kMicrohertz;
  const std::int64_t rest = ticks % rate_uhz;
  return {ticks / rate_uhz * kNsPerSecond + (rest * kNsPerSecond + rate_uhz / 2) / rate_uhz};
}

}  // namespace trilat
