// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Core>

#include "datasets/base/time.h"

namespace trilat {

// Linear in time between two samples at a.time <= t <= b.time that are no farther apart than
// `max_gap`; exactly on a sample, that sample, however far the other one is. Nothing outside of the
// two: a truth is never extrapolated.
template <class Clock>
std::optional<Eigen::Vector3d> interpolate(Instant<Clock> t, Instant<Clock> time_a,
                                           const Eigen::Vector3d& a_m, Instant<Clock> time_b,
                                           const Eigen::Vector3d& b_m, Duration max_gap) {
  if (t == time_a) return a_m;
  if (t == time_b) return b_m;
  if (t < time_a || time_b < t || time_b - time_a > max_gap) return std::nullopt;
  const double share = static_cast<double>((t - time_a).ns) / static_cast<double>((time_b - time_a).ns);
  return a_m + share * (b_m - a_m);
}

}  // namespace trilat
