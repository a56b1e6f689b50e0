// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "evaluators/solvers/point_estimate.h"

namespace trilat {

struct RatioChangeOptions {
  std::size_t resamples = 1000;
  std::uint64_t seed = 1;
};

// NaN where a side has fewer than two ratios, or one that is not positive and finite.
struct RatioChange {
  double now = kNaN, before = kNaN;  // medians
  double change = kNaN;              // now / before - 1
  double low = kNaN, high = kNaN;    // its 95 % interval: percentile bootstrap, each side by itself
  double chance = kNaN;              // two-sided, rank sum test of Mann and Whitney with ties
};

// Two sets of repeated measurements. Medians and ranks: a few rounds that were disturbed do not count more
// than others.
[[nodiscard]] RatioChange solve_ratio_change(std::span<const double> now, std::span<const double> before,
                                             const RatioChangeOptions& options);

}  // namespace trilat
