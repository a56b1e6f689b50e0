// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "datasets/base/time.h"

namespace trilat {

// A track at the instants it was sampled. Three lists of one length; times increase strictly; what
// is not valid is a gap and its point is never read.
template <class Clock>
struct SampledTrack {
  std::span<const Instant<Clock>> time;
  std::span<const Eigen::Vector3d> point_m;
  std::span<const std::uint8_t> valid;  // 0 or 1
};

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

// The track at t, from the valid samples nearest before and after it. Every instant asked for gets
// one point or none, and no sample is handed out as a match, so pairing is one to one by
// construction: no two estimates can claim the same truth, and none is shifted in time.
template <class Clock>
std::optional<Eigen::Vector3d> interpolate(const SampledTrack<Clock>& track, Instant<Clock> t,
                                           Duration max_gap) {
  const auto later = std::lower_bound(track.time.begin(), track.time.end(), t);
  std::size_t b = static_cast<std::size_t>(later - track.time.begin());
  std::size_t a = b;
  const std::size_t size = track.time.size();
  if (b < size && track.time[b] == t && track.valid[b] != 0) return track.point_m[b];
  while (b < size && track.valid[b] == 0 && track.time[b] - t <= max_gap) ++b;
  while (a > 0 && track.valid[a - 1] == 0 && t - track.time[a - 1] <= max_gap) --a;
  if (a == 0 || b == size || track.valid[a - 1] == 0 || track.valid[b] == 0) return std::nullopt;
  return interpolate(t, track.time[a - 1], track.point_m[a - 1], track.time[b], track.point_m[b], max_gap);
}

}  // namespace trilat
