// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace trilat {

// Points of a body at even steps of time: instants x points, metres, NaN where there is none.
struct PointStream {
  double first_s = 0.0, rate_hz = 30.0;
  std::size_t points = 0;
  std::vector<Eigen::Vector3d> at_m;

  std::size_t instants() const { return points == 0 ? 0 : at_m.size() / points; }
  double time_s(std::size_t instant) const { return first_s + static_cast<double>(instant) / rate_hz; }
  // Last instant less the first, in seconds.
  double duration_s() const { return instants() == 0 ? 0.0 : static_cast<double>(instants() - 1) / rate_hz; }
  const Eigen::Vector3d& at(std::size_t instant, std::size_t point) const {
    return at_m[instant * points + point];
  }
  // Positions at a time, linear between two instants; NaN outside, and beside an instant without the point.
  void at_time(double time_s, std::span<Eigen::Vector3d> position_m) const;
};

// For each name the index of its counterpart on the other side, or its own index where the name shows no
// side or its counterpart is missing. Knows left and right of some languages, L and R, and + and - at the
// end.
std::vector<std::size_t> mirrored_points(const std::vector<std::string>& names);

}  // namespace trilat
