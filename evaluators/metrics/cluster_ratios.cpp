// SPDX-License-Identifier: MIT
#include "evaluators/metrics/cluster_ratios.h"

#include <algorithm>
#include <cmath>

#include "datasets/base/philox.h"
#include "evaluators/metrics/error_statistics.h"
#include "evaluators/metrics/student.h"

namespace trilat {
namespace {

constexpr int kMeanResamples = 2000;
constexpr std::size_t kFewestResampled = 4;

// A mean of ratios whose numerators are scaled is their weighted sum.
RatioRange add_ratios(const std::vector<WeightedRatio>& sum, RowMatrix& columns,
                      std::vector<RatioColumns>& ratios) {
  const RatioRange range{ratios.size(), sum.size()};
  for (const WeightedRatio& ratio : sum) {
    const auto first = static_cast<Eigen::Index>(2 * ratios.size());
    const double scale = ratio.weight * static_cast<double>(sum.size());
    for (std::size_t c = 0; c < ratio.numerator.size(); ++c) {
      columns(static_cast<Eigen::Index>(c), first) = scale * ratio.numerator[c];
      columns(static_cast<Eigen::Index>(c), first + 1) = ratio.denominator[c];
    }
    ratios.push_back({2 * ratios.size(), 2 * ratios.size() + 1});
  }
  return range;
}

// How many clusters have a denominator of the quantity's ratios that is not 0.
std::size_t clusters_with_data(const Eigen::Ref<const RowMatrix>& sums, std::span<const RatioColumns> ratios,
                               const RatioRange& range) {
  std::size_t count = 0;
  for (Eigen::Index c = 0; c < sums.rows(); ++c)
    count += std::ranges::any_of(ratios.subspan(range.first, range.count), [&](const RatioColumns& ratio) {
      return sums(c, static_cast<Eigen::Index>(ratio.denominator)) > 0.0;
    });
  return count;
}

double half_width(const ContrastEstimate& e) {
  return e.clusters < 2 ? kNaN : student_quantile(e.clusters - 1) * e.standard_error;
}
double half_width(const ContrastEstimate& e, double alpha) {
  return e.clusters < 2 ? kNaN : student_quantile(e.clusters - 1, alpha) * e.standard_error;
}

}  // namespace

void ClusterRatios::set(const Eigen::Ref<const RowMatrix>& clusters) {
  const Eigen::RowVectorXd total = clusters.colwise().sum();
  for (std::size_t r = 0; r < ratios_.size(); ++r) {
    const double denominator = total[static_cast<Eigen::Index>(ratios_[r].denominator)];
    inverse_[r] = denominator > 0.0 ? 1.0 / denominator : kNaN;
    value_[r] =
        denominator > 0.0 ? total[static_cast<Eigen::Index>(ratios_[r].numerator)] / denominator : kNaN;
  }
  pull_.resize(clusters.rows(), static_cast<Eigen::Index>(ratios_.size()));
  for (Eigen::Index c = 0; c < clusters.rows(); ++c) {
    const double* row = clusters.data() + c * clusters.outerStride();
    double* pull = &pull_(c, 0);
    for (std::size_t r = 0; r < ratios_.size(); ++r)
      pull[r] = (row[ratios_[r].numerator] - value_[r] * row[ratios_[r].denominator]) * inverse_[r];
  }
}

bool ClusterRatios::has_data(const RatioRange& range) const {
  for (std::size_t r = 0; r < range.count; ++r)
    if (std::isnan(inverse_[range.first + r])) return false;
  return true;
}

double ClusterRatios::mean_of(const RatioRange& range) const {
  double sum = 0.0;
  for (std::size_t r = 0; r < range.count; ++r) sum += value_[range.first + r];
  return sum / static_cast<double>(range.count);
}

double ClusterRatios::pull_of(const RatioRange& range, Eigen::Index cluster) const {
  const double* pull = &pull_(cluster, 0) + range.first;
  if (range.count == 1) return *pull;
  double sum = 0.0;
  for (std::size_t r = 0; r < range.count; ++r) sum += pull[r];
  return sum / static_cast<double>(range.count);
}

Studentised ClusterRatios::of(std::size_t quantity, std::size_t clusters) const {
  const RatioQuantity& q = quantities_[quantity];
  const double by = q.divided_by ? mean_of(*q.divided_by) : 1.0;
  Studentised result;
  result.value = mean_of(q.mean);
  result.has_data = has_data(q.mean) && (!q.divided_by || has_data(*q.divided_by));
  result.value /= by;
  double squares = 0.0;
  for (Eigen::Index c = 0; c < pull_.rows(); ++c) {
    double pull = pull_of(q.mean, c);
    if (q.divided_by) pull = (pull - result.value * pull_of(*q.divided_by, c)) / by;
    squares += pull * pull;
  }
  const auto n = static_cast<double>(clusters);
  if (clusters >= 2) result.standard_error = std::sqrt(n / (n - 1.0) * squares);
  return result;
}

std::vector<IntervalEstimate> student_intervals(const Eigen::Ref<const RowMatrix>& sums,
                                                std::span<const RatioColumns> ratios,
                                                std::span<const RatioQuantity> quantities) {
  ClusterRatios solved(ratios, quantities);
  solved.set(sums);
  std::vector<IntervalEstimate> result;
  for (std::size_t q = 0; q < quantities.size(); ++q) {
    IntervalEstimate e;
    e.clusters = clusters_with_data(sums, ratios, quantities[q].mean);
    const Studentised found = solved.of(q, e.clusters);
    if (found.has_data && std::isfinite(found.value)) {
      e.value = found.value;
      e.standard_error = found.standard_error;
      if (e.clusters >= 2) {
        const double reach = student_quantile(e.clusters - 1) * e.standard_error;
        e.low = e.value - reach;
        e.high = e.value + reach;
      }
    }
    result.push_back(e);
  }
  return result;
}

double ContrastEstimate::low() const { return value - half_width(*this); }
double ContrastEstimate::high() const { return value + half_width(*this); }
double ContrastEstimate::low(double alpha) const { return value - half_width(*this, alpha); }
double ContrastEstimate::high(double alpha) const { return value + half_width(*this, alpha); }

ContrastEstimate solve_contrast(const Contrast& contrast) {
  if (contrast.value.empty()) return {};
  RowMatrix columns(static_cast<Eigen::Index>(contrast.value.front().numerator.size()),
                    static_cast<Eigen::Index>(2 * (contrast.value.size() + contrast.base.size())));
  std::vector<RatioColumns> ratios;
  RatioQuantity quantity{add_ratios(contrast.value, columns, ratios)};
  if (!contrast.base.empty()) quantity.divided_by = add_ratios(contrast.base, columns, ratios);
  const std::vector<RatioQuantity> quantities{quantity};
  ContrastEstimate result;
  result.clusters = clusters_with_data(columns, ratios, quantity.mean);
  ClusterRatios solved(ratios, quantities);
  solved.set(columns);
  const Studentised estimate = solved.of(0, result.clusters);
  if (!estimate.has_data) return result;
  result.value = estimate.value;
  result.standard_error = estimate.standard_error;
  return result;
}

bool is_told_apart(const ContrastEstimate& difference, std::size_t others) {
  constexpr double kChance = 0.05;
  if (!(difference.value > 0.0) || difference.clusters < 2) return false;
  const double one_sided =
      student_two_sided(difference.value / difference.standard_error, difference.clusters - 1) / 2.0;
  return one_sided < kChance / static_cast<double>(others);
}

std::pair<double, double> bootstrap_mean(const std::vector<double>& sums, const std::vector<double>& counts,
                                         std::uint64_t seed) {
  if (sums.size() < kFewestResampled) return {kNaN, kNaN};
  std::vector<double> means;
  for (std::uint64_t r = 0; r < kMeanResamples; ++r) {
    const RandomStream random{seed, Purpose::calibration_trial, random_item(0, 4, 0, r)};
    double sum = 0.0, count = 0.0;
    for (std::uint32_t k = 0; k < sums.size(); ++k) {
      const auto pick = static_cast<std::size_t>(random.uniform(k) * static_cast<double>(sums.size()));
      sum += sums[pick];
      count += counts[pick];
    }
    if (count > 0.0) means.push_back(sum / count);
  }
  if (means.empty()) return {kNaN, kNaN};
  const auto q = quantiles_of(means, {0.025, 0.975});
  return {q[0], q[1]};
}

}  // namespace trilat
