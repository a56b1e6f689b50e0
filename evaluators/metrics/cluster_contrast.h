// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "evaluators/solvers/point_estimate.h"

namespace trilat {

// A ratio of sums, of which every cluster (a participant, a sensor unit, a run) has its own part, times a
// weight.
struct WeightedRatio {
  std::vector<double> numerator, denominator;  // by cluster; a denominator is 0 where it has no samples
  double weight = 1.0;
};

// The sum of some ratios, divided by the sum of others when there are any.
struct Contrast {
  std::vector<WeightedRatio> value, base;
};

struct ContrastEstimate {
  double value = kNaN;
  double standard_error = kNaN;  // between clusters, by linearisation; NaN for fewer than 2
  std::size_t clusters = 0;      // with samples in any ratio of `value`
  // 95 % by Student's t with one degree of freedom less than clusters; NaN without a standard error.
  double low() const;
  double high() const;
};

// Every cluster enters all its ratios at once, so that what its samples share cancels where it is subtracted.
// NaN when a ratio has no samples at all. What coverage such intervals have: block_bootstrap.h, the row
// "Student's t times se".
ContrastEstimate solve_contrast(const Contrast& contrast);

}  // namespace trilat
