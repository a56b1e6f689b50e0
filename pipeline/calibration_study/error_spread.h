// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "datasets/results/calibration_summary.h"

namespace trilat {

// One error and the cluster it belongs to (a unit, a run): errors of one cluster have causes in common.
struct ClusteredError {
  std::size_t cluster = 0;
  double error_m = ErrorSpread::kNone;  // NaN: no answer
};

// Mean, spread and quantiles, with an interval of the mean by bootstrap over clusters (none with fewer than
// four). `seed` makes the resampling; equal inputs give equal results.
ErrorSpread spread_of(const std::vector<ClusteredError>& errors, std::uint64_t seed);

// 95 % interval of the mean of `values`, one a cluster, by bootstrap; NaN with fewer than four.
std::pair<double, double> bootstrap_mean(const std::vector<double>& sums, const std::vector<double>& counts,
                                         std::uint64_t seed);

}  // namespace trilat
