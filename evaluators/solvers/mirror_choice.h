// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Core>

namespace trilat {

// Two solutions that fit equally well, and which of them is meant. A hint decides when it is less
// than half as far from one as from the other; otherwise the choice is ambiguous, and `first` tells
// the nearer one (the first, without a hint).
struct MirrorChoice {
  bool first = true;
  bool decided = false;
};

inline MirrorChoice choose_mirror(const Eigen::Vector3d& first_m, const Eigen::Vector3d& second_m,
                                  const std::optional<Eigen::Vector3d>& hint_m) {
  if (!hint_m) return {};
  const double to_first_m = (*hint_m - first_m).norm();
  const double to_second_m = (*hint_m - second_m).norm();
  return {to_first_m <= to_second_m, to_first_m < 0.5 * to_second_m || to_second_m < 0.5 * to_first_m};
}

}  // namespace trilat
