// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "evaluators/solvers/point_estimate.h"

namespace trilat {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Two columns of sums: sum of the one / sum of the other, which is >= 0.
struct RatioColumns {
  std::size_t numerator = 0, denominator = 0;
};

// What an interval is wanted for: the plain mean of some ratios, or one such mean divided by another. Ratios
// are meant by their places in a list.
struct RatioRange {
  std::size_t first = 0, count = 1;
};
struct RatioQuantity {
  RatioRange mean;
  std::optional<RatioRange> divided_by = {};
};

struct Studentised {
  double value = kNaN;
  double standard_error = kNaN;  // between clusters, by linearisation
  bool has_data = false;         // no denominator is 0
};

// Quantities of one set of clusters.
class ClusterRatios {
 public:
  ClusterRatios(std::span<const RatioColumns> ratios, std::span<const RatioQuantity> quantities)
      : ratios_(ratios), quantities_(quantities), value_(ratios.size()), inverse_(ratios.size()) {}

  // One row of sums a cluster.
  void set(const Eigen::Ref<const RowMatrix>& clusters);
  // `clusters`: how many of the rows have data for it.
  Studentised of(std::size_t quantity, std::size_t clusters) const;

 private:
  bool has_data(const RatioRange& range) const;
  double mean_of(const RatioRange& range) const;
  double pull_of(const RatioRange& range, Eigen::Index cluster) const;

  std::span<const RatioColumns> ratios_;
  std::span<const RatioQuantity> quantities_;
  std::vector<double> value_, inverse_;  // by ratio; inverse_ of the total denominator
  RowMatrix pull_;                       // clusters x ratios: what each cluster moves the ratio by
};

// NaN where there is none.
struct IntervalEstimate {
  double value = kNaN;
  double low = kNaN, high = kNaN;  // 95 %, by Student's t between clusters
  double standard_error = kNaN;
  std::size_t clusters = 0;  // with data
};

// Estimates with their intervals from sums: `sums` is clusters x columns. Each quantity by itself: the result
// does not depend on which others are asked for. The standard error is that between clusters, by
// linearisation: u_k is what cluster k pulls the quantity by, se^2 = n / (n - 1) sum u_k^2 (Cochran, Sampling
// Techniques, 1977, section 6.4); the interval is t times se on either side, of n - 1 degrees of freedom. How
// often it covers the truth: docs/explanation/intervals.md.
[[nodiscard]] std::vector<IntervalEstimate> student_intervals(const Eigen::Ref<const RowMatrix>& sums,
                                                              std::span<const RatioColumns> ratios,
                                                              std::span<const RatioQuantity> quantities);

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
};

// Every cluster enters all its ratios at once, so that what its samples share cancels where it is subtracted.
// NaN when a ratio has no samples at all.
ContrastEstimate solve_contrast(const Contrast& contrast);

// Whether the first method of a paired difference (first - best) errs more than the best of it and `others`
// methods in all: a one-sided test at 0.05 / others, since the best was chosen by the data that it is tested
// on. The methods that do not then hold the truly best in 95 % of campaigns at least. False without a
// standard error.
bool is_told_apart(const ContrastEstimate& difference, std::size_t others);

// 95 % interval of sum(sums) / sum(counts), one of each a cluster, by bootstrap over clusters; NaN with fewer
// than four.
std::pair<double, double> bootstrap_mean(const std::vector<double>& sums, const std::vector<double>& counts,
                                         std::uint64_t seed);

}  // namespace trilat
