// SPDX-License-Identifier: MIT
#include "evaluators/metrics/cluster_ratios.h"

#include <algorithm>
#include <cmath>

#include "evaluators/metrics/student.h"

namespace trilat {
namespace {

double half_width(const ContrastEstimate& e, double alpha) {
  return e.clusters < 2 ? kNaN : student_quantile(e.clusters - 1, alpha) * e.standard_error;
}

// The weighted sum of some ratios, and what each cluster pulls it by.
struct RatioSum {
  double value = 0.0;
  std::vector<double> pull;
};

RatioSum sum_of(const std::vector<WeightedRatio>& ratios, std::size_t clusters) {
  RatioSum sum{0.0, std::vector<double>(clusters)};
  for (const WeightedRatio& ratio : ratios) {
    double numerator = 0.0, denominator = 0.0;
    for (const double x : ratio.numerator) numerator += x;
    for (const double x : ratio.denominator) denominator += x;
    const double value = denominator > 0.0 ? numerator / denominator : kNaN;
    sum.value += ratio.weight * value;
    for (std::size_t c = 0; c < clusters; ++c)
      sum.pull[c] += ratio.weight * (ratio.numerator[c] - value * ratio.denominator[c]) / denominator;
  }
  return sum;
}

}  // namespace

double ContrastEstimate::low() const { return low(0.05); }
double ContrastEstimate::high() const { return high(0.05); }
double ContrastEstimate::low(double alpha) const { return value - half_width(*this, alpha); }
double ContrastEstimate::high(double alpha) const { return value + half_width(*this, alpha); }
double ContrastEstimate::p_value() const {
  return clusters < 2 ? kNaN : student_two_sided(value / standard_error, clusters - 1);
}

ContrastEstimate solve_contrast(const Contrast& contrast) {
  ContrastEstimate result;
  if (contrast.value.empty()) return result;
  const std::size_t clusters = contrast.value.front().numerator.size();
  for (std::size_t c = 0; c < clusters; ++c)
    result.clusters += std::ranges::any_of(
        contrast.value, [&](const WeightedRatio& ratio) { return ratio.denominator[c] > 0.0; });
  RatioSum value = sum_of(contrast.value, clusters);
  if (!contrast.base.empty()) {
    const RatioSum base = sum_of(contrast.base, clusters);
    value.value /= base.value;
    for (std::size_t c = 0; c < clusters; ++c)
      value.pull[c] = (value.pull[c] - value.value * base.pull[c]) / base.value;
  }
  if (std::isnan(value.value)) return result;
  result.value = value.value;
  if (result.clusters < 2) return result;
  double squares = 0.0;
  for (const double pull : value.pull) squares += pull * pull;
  const auto n = static_cast<double>(result.clusters);
  result.standard_error = std::sqrt(n / (n - 1.0) * squares);
  return result;
}

bool differs_significantly(const ContrastEstimate& difference, std::size_t others) {
  constexpr double kChance = 0.05;
  if (!(difference.value > 0.0) || difference.clusters < 2) return false;
  return difference.p_value() / 2.0 < kChance / static_cast<double>(others);
}

std::pair<double, double> mean_interval(const std::vector<double>& sums, const std::vector<double>& counts) {
  const ContrastEstimate mean = solve_contrast({{{sums, counts}}, {}});
  return {mean.low_of_size(), mean.high()};
}

}  // namespace trilat
