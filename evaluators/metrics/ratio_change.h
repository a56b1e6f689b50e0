// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "evaluators/solvers/point_estimate.h"

namespace trilat {

struct RatioChangeOptions {
  double quantile = 0.25;  // that stands for all: what disturbs a measurement only makes it longer
  std::size_t block = 24;  // neighbours that are disturbed together
  std::size_t resamples = 1000;
  std::uint64_t seed = 1;
};

// NaN where a side has fewer than two blocks, or a ratio that is not positive and finite.
struct RatioChange {
  double now = kNaN, before = kNaN;  // quantiles
  double change = kNaN;              // now / before - 1
  double low = kNaN, high = kNaN;    // its 95 % interval: percentile bootstrap of blocks, each side by itself
  double chance = kNaN;  // two-sided: of the logarithm, normal with the standard deviation of the bootstrap
};

// Two sets of repeated measurements, in the order they were made; what is beyond whole blocks belongs to the
// last.
[[nodiscard]] RatioChange solve_ratio_change(std::span<const double> now, std::span<const double> before,
                                             const RatioChangeOptions& options);

// The quantile of unsorted values (type 7 of Hyndman and Fan 1996); NaN without any.
double quantile_of(std::vector<double> values, double quantile);

}  // namespace trilat
