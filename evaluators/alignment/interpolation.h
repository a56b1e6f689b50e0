// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "datasets/base/time.h"

namespace trilat {

// Path of a point: times rise, positions are NaN where it was not seen.
struct PointPath {
  std::vector<double> time_s;
  std::vector<Eigen::Vector3d> position_m;
};

struct LocalMotion {
  Eigen::Vector3d position_m;
  Eigen::Vector3d velocity_m_s;
};

// The straight line of weighted least squares through the samples about `time_s`, with weights of a Gaussian
// of `sigma_s` that ends at three sigma: the same smoothing in seconds whatever the rate of the path. Nothing
// where the samples do not cover the time: fewer than three, none on one side, or a hole wider than
// `longest_gap_s` or, if that is more, 1.5 sigma.
std::optional<LocalMotion> local_motion(const PointPath& path, double time_s, double sigma_s,
                                        double longest_gap_s);

// Linear in time between two samples at a.time <= t <= b.time that are no farther apart than `max_gap`;
// exactly on a sample, that sample, however far the other one is. Nothing outside of the two: a truth is
// never extrapolated.
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
