// SPDX-License-Identifier: MIT
#include "evaluators/metrics/block_bootstrap.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "datasets/base/error.h"
#include "datasets/base/philox.h"
#include "evaluators/metrics/cluster_ratios.h"
#include "evaluators/metrics/student.h"

namespace trilat {
namespace {

using Eigen::Index;

constexpr std::size_t kTogether = 16;        // resamples that one matrix product takes
constexpr std::size_t kFewestClusters = 6;   // of the bootstrap-t
constexpr std::size_t kFewestStudents = 20;  // resamples; fewer have no tails

Index as_index(std::size_t i) { return static_cast<Index>(i); }

// Columns that are equal to an earlier one are carried only once: counts are often the same everywhere.
struct DistinctColumns {
  RowMatrix sums;
  std::vector<std::size_t> place;  // by column
};

DistinctColumns distinct_columns(const Eigen::MatrixXd& sums) {
  std::vector<Index> kept;
  DistinctColumns result;
  for (Index c = 0; c < sums.cols(); ++c) {
    const auto same = std::ranges::find_if(kept, [&](Index k) { return sums.col(k) == sums.col(c); });
    result.place.push_back(static_cast<std::size_t>(same - kept.begin()));
    if (same == kept.end()) kept.push_back(c);
  }
  result.sums = sums(Eigen::all, kept);
  return result;
}

// The sums at every place of the resamples [first, first + count), one product a cluster.
void resampled_sums(const RowMatrix& sums, const BlockResamples& resamples, std::size_t first,
                    std::size_t count, RowMatrix& result) {
  const std::size_t places = count * resamples.clusters, start = first * resamples.clusters;
  result.resize(as_index(places), sums.cols());
  std::vector<std::size_t> drawn;
  RowMatrix weights, products;
  for (std::size_t c = 0; c < resamples.clusters; ++c) {
    drawn.clear();
    for (std::size_t p = 0; p < places; ++p)
      if (resamples.drawn[start + p] == c) drawn.push_back(p);
    if (drawn.empty()) continue;
    const Index first_block = as_index(resamples.first_block[c]);
    const Index blocks = as_index(resamples.first_block[c + 1]) - first_block;
    weights.resize(as_index(drawn.size()), blocks);
    for (std::size_t d = 0; d < drawn.size(); ++d) {
      const std::uint16_t* weight = &resamples.block_weight[resamples.first_weight[start + drawn[d]]];
      for (Index b = 0; b < blocks; ++b) weights(as_index(d), b) = weight[b];
    }
    products.noalias() = weights * sums.middleRows(first_block, blocks);
    for (std::size_t d = 0; d < drawn.size(); ++d) result.row(as_index(drawn[d])) = products.row(as_index(d));
  }
}

RowMatrix cluster_sums(const RowMatrix& sums, const BlockResamples& resamples) {
  RowMatrix result(as_index(resamples.clusters), sums.cols());
  for (std::size_t c = 0; c < resamples.clusters; ++c)
    result.row(as_index(c)) =
        sums.middleRows(as_index(resamples.first_block[c]),
                        as_index(resamples.first_block[c + 1] - resamples.first_block[c]))
            .colwise()
            .sum();
  return result;
}

// What is known without resampling.
IntervalEstimate estimate_of(const Studentised& found, std::size_t clusters, std::size_t resamples) {
  IntervalEstimate result;
  result.clusters = clusters;
  result.status = IntervalStatus::no_data;
  if (clusters == 0 || !found.has_data) return result;
  result.status = IntervalStatus::not_finite;
  if (!std::isfinite(found.value)) return result;
  result.value = found.value;
  result.status = IntervalStatus::too_few_clusters;
  if (clusters < 2) return result;
  result.standard_error = found.standard_error;
  result.status = resamples == 0 ? IntervalStatus::no_resamples : IntervalStatus::found;
  return result;
}

void set_interval(IntervalEstimate& estimate, std::vector<double>& students) {
  double low = 0.0, high = 0.0;  // of (value* - value) / se*
  if (estimate.clusters < kFewestClusters) {
    high = student_quantile(estimate.clusters - 1);
    low = -high;
  } else if (students.size() >= kFewestStudents) {
    std::ranges::sort(students);
    const auto quantile = [&](double q) {  // type 7 of Hyndman and Fan 1996
      const double position = q * static_cast<double>(students.size() - 1);
      const auto below = static_cast<std::size_t>(position);
      const double share = position - static_cast<double>(below);
      return students[below] + share * (students[below + 1] - students[below]);
    };
    const double student = student_quantile(estimate.clusters - 1);
    low = std::min(quantile(0.025), -student);
    high = std::max(quantile(0.975), student);
  } else if (estimate.standard_error > 0.0) {
    estimate.status = IntervalStatus::too_few_clusters;
    return;
  }
  estimate.low = estimate.value - high * estimate.standard_error;
  estimate.high = estimate.value - low * estimate.standard_error;
  if (std::isfinite(estimate.low) && std::isfinite(estimate.high)) return;
  estimate.low = estimate.high = kNaN;
  estimate.status = IntervalStatus::too_few_clusters;
}

std::size_t pick(const RandomStream& random, std::uint32_t& draw, std::size_t count) {
  const auto picked = static_cast<std::size_t>(random.uniform(draw++) * static_cast<double>(count));
  return std::min(picked, count - 1);
}

}  // namespace

std::string_view name_of(IntervalStatus status) {
  constexpr std::array<std::string_view, 6> kNames{"not_solved",       "found",        "no_data",
                                                   "too_few_clusters", "no_resamples", "not_finite"};
  return kNames.at(static_cast<std::size_t>(status));
}

std::vector<IntervalEstimate> solve_intervals(const Eigen::MatrixXd& sums, const BlockResamples& resamples,
                                              std::span<const RatioColumns> ratios,
                                              std::span<const BootstrapQuantity> quantities) {
  TRILAT_CHECK(as_index(resamples.first_block.back()) == sums.rows(), "every block has a row");
  const DistinctColumns columns = distinct_columns(sums);
  std::vector<RatioColumns> places;
  for (const RatioColumns& ratio : ratios)
    places.push_back({columns.place.at(ratio.numerator), columns.place.at(ratio.denominator)});
  ClusterRatios statistics(places, quantities);
  const RowMatrix clusters = cluster_sums(columns.sums, resamples);
  statistics.set(clusters);
  const ClustersWithData with_data(clusters, places, quantities);
  std::vector<IntervalEstimate> estimates;
  bool any = false;
  for (std::size_t q = 0; q < quantities.size(); ++q) {
    estimates.push_back(
        estimate_of(statistics.of(q, with_data.count(q)), with_data.count(q), resamples.resamples));
    any |= estimates[q].status == IntervalStatus::found && estimates[q].clusters >= kFewestClusters;
  }
  std::vector<std::vector<double>> students(quantities.size());
  RowMatrix resampled;
  for (std::size_t first = 0; any && first < resamples.resamples; first += kTogether) {
    const std::size_t count = std::min(kTogether, resamples.resamples - first);
    resampled_sums(columns.sums, resamples, first, count, resampled);
    for (std::size_t r = 0; r < count; ++r) {
      const std::size_t start = (first + r) * resamples.clusters;
      statistics.set(resampled.middleRows(as_index(r * resamples.clusters), as_index(resamples.clusters)));
      const std::span drawn(&resamples.drawn[start], resamples.clusters);
      for (std::size_t q = 0; q < quantities.size(); ++q) {
        if (estimates[q].status != IntervalStatus::found) continue;
        const Studentised replicate = statistics.of(q, with_data.count_of(q, drawn));
        if (replicate.standard_error == 0.0) continue;  // one cluster drawn again and again: says nothing
        const double student = (replicate.value - estimates[q].value) / replicate.standard_error;
        if (!std::isnan(student)) students[q].push_back(student);
      }
    }
  }
  for (std::size_t q = 0; q < quantities.size(); ++q)
    if (estimates[q].status == IntervalStatus::found) set_interval(estimates[q], students[q]);
  return estimates;
}

BlockResamples draw_resamples(const std::vector<std::size_t>& cluster_of_block,
                              const ResampleOptions& options) {
  BlockResamples result;
  result.first_block = {0};
  for (std::size_t b = 0; b < cluster_of_block.size(); ++b) {
    const std::size_t here = b == 0 ? 0 : cluster_of_block[b - 1];
    TRILAT_CHECK(cluster_of_block[b] == here || (b > 0 && cluster_of_block[b] == here + 1),
                 "blocks come cluster by cluster");
    if (b > 0 && cluster_of_block[b] != here) result.first_block.push_back(b);
  }
  if (!cluster_of_block.empty()) result.first_block.push_back(cluster_of_block.size());
  result.clusters = result.first_block.size() - 1;
  result.resamples = options.resamples;
  constexpr std::size_t kMost = 65'536;
  TRILAT_CHECK(result.clusters < kMost, "clusters can be numbered");
  result.first_weight = {0};
  for (std::size_t r = 0; r < options.resamples; ++r) {
    const RandomStream random{options.seed, Purpose::bootstrap, r};
    std::uint32_t draw = 0;
    for (std::size_t place = 0; place < result.clusters; ++place) {
      const std::size_t cluster = pick(random, draw, result.clusters);
      const std::size_t blocks = result.first_block[cluster + 1] - result.first_block[cluster];
      TRILAT_CHECK(blocks < kMost, "draws of a block can be counted");
      result.drawn.push_back(static_cast<std::uint16_t>(cluster));
      const std::size_t first = result.block_weight.size();
      result.block_weight.resize(first + blocks);
      for (std::size_t b = 0; b < blocks; ++b) ++result.block_weight[first + pick(random, draw, blocks)];
      result.first_weight.push_back(result.block_weight.size());
    }
  }
  return result;
}

}  // namespace trilat
