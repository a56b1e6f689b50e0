// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "evaluators/metrics/cluster_ratios.h"
#include "evaluators/solvers/point_estimate.h"

namespace trilat {

struct ResampleOptions {
  std::size_t resamples = 2000;  // 0: no intervals
  std::uint64_t seed = 1;
};

// Resamples of data in two levels: as many clusters as there are are drawn with replacement, and within every
// drawn one as many of its blocks as it has, with replacement. Each draw is a function of the seed, the
// resample and its place alone.
struct BlockResamples {
  std::size_t clusters = 0;
  std::size_t resamples = 0;
  std::vector<std::size_t> first_block;     // by cluster, and one behind the last
  std::vector<std::uint16_t> drawn;         // cluster, by resample and place
  std::vector<std::size_t> first_weight;    // into `weights`, by resample and place, and one behind the last
  std::vector<std::uint16_t> block_weight;  // how often each block of the drawn cluster was drawn
};

// `cluster_of_block` does not fall and leaves no cluster out; fewer than 65,536 clusters and blocks a cluster
// (InternalError).
BlockResamples draw_resamples(const std::vector<std::size_t>& cluster_of_block,
                              const ResampleOptions& options);

enum class IntervalStatus : std::uint8_t {
  not_solved = 0,
  found = 1,
  no_data = 2,           // a denominator is 0: there is no value either
  too_few_clusters = 3,  // fewer than 2 have data: what differs between them cannot be known
  no_resamples = 4,      // none were asked for
  not_finite = 5,        // a sum is NaN or infinite, or the value is divided by 0
};
std::string_view name_of(IntervalStatus status);

// NaN where there is none.
struct IntervalEstimate {
  IntervalStatus status = IntervalStatus::not_solved;
  double value = kNaN;
  double low = kNaN, high = kNaN;  // 95 %
  double standard_error = kNaN;
  std::size_t clusters = 0;  // with data
};

// Estimates with their 95 % intervals from sums over blocks: `sums` is blocks x columns, in the order of the
// resamples' blocks. Each quantity by itself: the result does not depend on which others are asked for.
//
// The standard error is that between clusters, by linearisation: u_k is what cluster k pulls the quantity by,
// se^2 = n / (n - 1) sum u_k^2 (Cochran, Sampling Techniques, 1977, section 6.4). The interval is, on each
// side, the wider of Student's t times se and of the bootstrap-t of Efron and Tibshirani (1993, section
// 12.5): value - se times the quantiles of (value* - value) / se* over the resamples. How often each kind by
// itself covered the truth, of 1000 simulated campaigns with 35 blocks a cluster and errors of clusters,
// blocks and samples; last two columns: gamma-distributed errors, and clusters that do not differ:
//
//   clusters                          16     8     4   | 16     8     4   | 16, clusters equal
//   percentile                       92.3  87.9  82.9  | 92.4  89.5  78.1  | 99.5
//   percentile, t and n / (n - 1)    94.3  93.5  92.5  | 94.7  94.0  89.5  | 99.8
//   BCa                              91.7  86.7  82.2  | 92.6  89.4  80.0  | 99.5
//   Student's t times se             94.0  94.3  95.0  | 94.2  93.5  91.4  | 95.6
//   bootstrap-t                      94.3  94.0  95.2  | 95.2  95.1  93.5  | 95.4
//
// The others are too wide where clusters are equal because drawing clusters and then blocks counts the spread
// of blocks twice; se* has it twice as well. Fewer than six clusters have too few different resamples for
// tails (of two, half are one cluster twice; of four the bootstrap-t is twice as wide without covering more
// of normal errors): there it is Student's t times se (95.1 of two, 94.4 of three).
[[nodiscard]] std::vector<IntervalEstimate> solve_intervals(const Eigen::MatrixXd& sums,
                                                            const BlockResamples& resamples,
                                                            std::span<const RatioColumns> ratios,
                                                            std::span<const BootstrapQuantity> quantities);

}  // namespace trilat
