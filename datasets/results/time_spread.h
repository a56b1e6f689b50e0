// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string>

#include "datasets/base/strict_json.h"

namespace trilat {

// The paper's ranges of Table IV: each from its edge to the next, the last without an end. A duration below
// 11 ms that is no clock error falls into one of the first three, which the paper counts as (0, 11).
inline constexpr std::array<double, 6> kTimeEdges_s{0.0, 0.002, 0.004, 0.011, 0.022, 0.033};

// How durations, or absolute errors of clocks, are spread. NaN without any.
struct TimeSpread {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::uint64_t n = 0;
  std::array<std::uint64_t, kTimeEdges_s.size()> bins{};
  double median_s = kNone, p95_s = kNone, p99_s = kNone, p999_s = kNone, max_s = kNone;
};

Json json_of(const TimeSpread& spread);
// InputError when the bins do not add up.
TimeSpread read_time_spread(JsonObject object);

}  // namespace trilat
