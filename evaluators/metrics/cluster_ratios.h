// SPDX-License-Identifier: MIT
#pragma once

#include <utility>
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
  // 95 %, or 1 - alpha, by Student's t with one degree of freedom less than clusters; NaN without a standard
  // error.
  double low() const;
  double high() const;
  double low(double alpha) const;
  double high(double alpha) const;
  double p_value() const;  // of a difference from zero, two-sided
  // low() of a mean of lengths or other sizes, none of which is below zero.
  double low_of_size() const { return low() < 0.0 ? 0.0 : low(); }
};

// Every cluster enters all its ratios at once, so that what its samples share cancels where it is subtracted.
// NaN when a ratio has no samples at all. The standard error is that between clusters, by linearisation: u_k
// is what cluster k pulls the value by, se^2 = n / (n - 1) sum u_k^2 (Cochran, Sampling Techniques, 1977,
// section 6.4). How often the intervals cover the truth: docs/explanation/intervals.md.
ContrastEstimate solve_contrast(const Contrast& contrast);

// Whether a method errs significantly more than the best of `others` methods, by the paired difference to it:
// a one-sided test at 0.05 / others (Bonferroni), since the best was chosen by the data that it is tested
// on. The methods that do not then hold the truly best in 95 % of campaigns at least. False without a
// standard error.
bool differs_significantly(const ContrastEstimate& difference, std::size_t others);

// The 95 % interval of the mean size sum(sums) / sum(counts), one of each a cluster; not below zero, and NaN
// with fewer than two.
std::pair<double, double> mean_interval(const std::vector<double>& sums, const std::vector<double>& counts);

}  // namespace trilat
