// SPDX-License-Identifier: MIT
#include "evaluators/metrics/statistics.h"

#include <algorithm>
#include <cmath>

#include <gsl/gsl_cdf.h>
#include <gsl/gsl_errno.h>

#include "datasets/base/error.h"

namespace trilat {
namespace {

// GSL ends the program at an error unless its handler is off; what it returns is checked instead.
[[maybe_unused]] const auto kHandlerOff = gsl_set_error_handler_off();

// The tests, the smallest probability first.
std::vector<std::size_t> in_order(std::span<const double> p) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < p.size(); ++i)
    if (!std::isnan(p[i])) order.push_back(i);
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return p[a] < p[b]; });
  return order;
}

}  // namespace

std::vector<double> holm_adjusted(std::span<const double> p) {
  const std::vector<std::size_t> order = in_order(p);
  std::vector<double> adjusted(p.size(), kNaN);
  double largest = 0.0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    largest = std::max(largest, std::min(1.0, static_cast<double>(order.size() - k) * p[order[k]]));
    adjusted[order[k]] = largest;
  }
  return adjusted;
}

double student_quantile(std::size_t degrees, double alpha) {
  if (degrees == 0) return kNaN;
  const double quantile = gsl_cdf_tdist_Qinv(0.5 * alpha, static_cast<double>(degrees));
  TRILAT_CHECK(std::isfinite(quantile), "Student's t can be inverted");
  return quantile;
}

double student_two_sided(double t, std::size_t degrees) {
  if (std::isnan(t) || degrees == 0) return kNaN;
  return 2.0 * gsl_cdf_tdist_Q(std::abs(t), static_cast<double>(degrees));
}

double chi_square_limit(double sigmas, double dimensions) {
  const double p = std::erfc(sigmas / std::sqrt(2.0));
  return p > 0.0 ? gsl_cdf_chisq_Qinv(p, dimensions) : sigmas * sigmas;
}

double gamma_quantile(double p, double shape, double scale) {
  TRILAT_CHECK(
      p > 0.0 && p < 1.0 && shape > 0.0 && scale > 0.0 && std::isfinite(shape) && std::isfinite(scale),
      "a gamma distribution has a finite shape and scale");
  double low = 0.0, high = shape + 1.0;  // of scale 1
  while (gsl_cdf_gamma_P(high, shape, 1.0) < p) high *= 2.0;
  // Halving ends at two neighbouring numbers.
  for (double middle = 0.5 * high; middle > low && middle < high; middle = 0.5 * (low + high))
    (gsl_cdf_gamma_P(middle, shape, 1.0) < p ? low : high) = middle;
  return high * scale;
}

namespace {

double half_width(const Estimate& e, double alpha) {
  return e.clusters < 2 ? kNaN : student_quantile(e.clusters - 1, alpha) * e.standard_error;
}

// The weighted sum of some ratios, and what each cluster pulls it by.
struct RatioSum {
  double value = 0.0;
  std::vector<double> influence;
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
      sum.influence[c] += ratio.weight * (ratio.numerator[c] - value * ratio.denominator[c]) / denominator;
  }
  return sum;
}

}  // namespace

double Estimate::low() const { return low(0.05); }
double Estimate::high() const { return high(0.05); }
double Estimate::low(double alpha) const { return value - half_width(*this, alpha); }
double Estimate::high(double alpha) const { return value + half_width(*this, alpha); }
double Estimate::p_value() const {
  return clusters < 2 ? kNaN : student_two_sided(value / standard_error, clusters - 1);
}

Estimate solve_contrast(const Contrast& contrast) {
  Estimate result;
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
      value.influence[c] = (value.influence[c] - value.value * base.influence[c]) / base.value;
  }
  if (std::isnan(value.value)) return result;
  result.value = value.value;
  if (result.clusters < 2) return result;
  double squares = 0.0;
  for (const double influence : value.influence) squares += influence * influence;
  const auto n = static_cast<double>(result.clusters);
  result.standard_error = std::sqrt(n / (n - 1.0) * squares);
  return result;
}

bool differs_significantly(const Estimate& difference, std::size_t others) {
  constexpr double kChance = 0.05;
  if (!(difference.value > 0.0) || difference.clusters < 2) return false;
  return difference.p_value() / 2.0 < kChance / static_cast<double>(others);
}

std::pair<double, double> mean_interval(const std::vector<double>& sums, const std::vector<double>& counts) {
  const Estimate mean = solve_contrast({{{sums, counts}}, {}});
  return {mean.low_of_size(), mean.high()};
}

namespace {

// The quantile of the beta distribution at probability `p`. GSL's own inverse fails for large a and b, so the
// distribution itself is inverted: halving ends at two neighbouring numbers.
double beta_quantile(double p, double a, double b) {
  double low = 0.0, high = 1.0;
  for (double middle = 0.5; middle > low && middle < high; middle = 0.5 * (low + high))
    (gsl_cdf_beta_P(middle, a, b) < p ? low : high) = middle;
  return high;
}

}  // namespace

double ShareEstimate::chance_of_more(double share) const {
  if (!std::isfinite(trials) || successes <= 0.0) return 1.0;
  return gsl_cdf_beta_P(share, successes, trials - successes + 1.0);
}

double ShareEstimate::chance_of_fewer(double share) const {
  if (!std::isfinite(trials) || successes >= trials) return 1.0;
  return gsl_cdf_beta_Q(share, successes + 1.0, trials - successes);
}

ShareEstimate estimate_share(double successes, double trials) {
  constexpr double kTail = 0.025;
  ShareEstimate share{.successes = successes, .trials = trials, .clusters = static_cast<std::size_t>(trials)};
  if (!(trials > 0.0)) return {};
  share.value = successes / trials;
  share.low = successes <= 0.0 ? 0.0 : beta_quantile(kTail, successes, trials - successes + 1.0);
  share.high = successes >= trials ? 1.0 : beta_quantile(1.0 - kTail, successes + 1.0, trials - successes);
  return share;
}

ShareEstimate estimate_share(const std::vector<double>& successes, const std::vector<double>& samples) {
  const Estimate mean = solve_contrast({{{successes, samples}}, {}});
  ShareEstimate none{.value = mean.value, .clusters = mean.clusters};
  if (mean.clusters < 2) return none;
  double all = 0.0;
  for (const double n : samples) all += n;
  const auto clusters = static_cast<double>(mean.clusters);
  double trials = clusters;
  if (mean.standard_error > 0.0) {
    trials = mean.value * (1.0 - mean.value) / (mean.standard_error * mean.standard_error);
    const double t_of_samples = student_quantile(static_cast<std::size_t>(std::max(1.0, all - 1.0)));
    trials *= std::pow(t_of_samples / student_quantile(mean.clusters - 1), 2);
    trials = std::min(trials, all);
  }
  ShareEstimate share = estimate_share(mean.value * trials, trials);
  share.value = mean.value;
  share.clusters = mean.clusters;
  return share;
}

namespace {

// Puts the values of all `ranks`, which rise, in their places; `values` begins at rank `first`.
void place(std::span<double> values, std::size_t first, std::span<const std::size_t> ranks) {
  if (ranks.empty()) return;
  const std::size_t middle = ranks.size() / 2, at = ranks[middle] - first;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(at), values.end());
  place(values.first(at), first, ranks.first(middle));
  place(values.subspan(at + 1), ranks[middle] + 1, ranks.subspan(middle + 1));
}

}  // namespace

std::vector<double> quantiles_of(std::vector<double> values, const std::vector<double>& quantiles) {
  TRILAT_CHECK(std::ranges::is_sorted(quantiles) &&
                   (quantiles.empty() || (quantiles.front() >= 0.0 && quantiles.back() <= 1.0)),
               "quantiles rise from 0 to 1");
  TRILAT_CHECK(std::ranges::none_of(values, [](double x) { return std::isnan(x); }), "a value is a number");
  std::vector<double> result(quantiles.size(), kNaN);
  if (values.empty()) return result;
  const std::size_t last = values.size() - 1;
  std::vector<std::size_t> ranks;
  for (const double q : quantiles)
    for (const std::size_t above : {0, 1})
      ranks.push_back(
          std::min(static_cast<std::size_t>(std::floor(static_cast<double>(last) * q)) + above, last));
  std::ranges::sort(ranks);
  ranks.erase(std::unique(ranks.begin(), ranks.end()), ranks.end());
  place(values, 0, ranks);
  for (std::size_t i = 0; i < quantiles.size(); ++i) {
    const double position = static_cast<double>(last) * quantiles[i], share = position - std::floor(position);
    const auto rank = static_cast<std::size_t>(position);
    const double below = values[rank], above = values[std::min(rank + 1, last)];
    result[i] = share == 0.0 || below == above ? below : below + share * (above - below);
  }
  return result;
}

Agreement limits_of_agreement(std::span<const DifferenceSums> persons) {
  constexpr double kNormal95 = 1.96;
  Agreement result;
  double n = 0.0, sum = 0.0, n2 = 0.0, within = 0.0;
  for (const DifferenceSums& p : persons) {
    if (p.n <= 0.0) continue;
    ++result.persons;
    n += p.n;
    n2 += p.n * p.n;
    sum += p.sum;
    within += std::max(0.0, p.sum2 - p.sum * p.sum / p.n);
  }
  if (result.persons == 0) return result;
  const auto k = static_cast<double>(result.persons);
  result.bias = sum / n;
  const double within2 = n > k ? within / (n - k) : 0.0;  // the mean square within persons
  double between2 = 0.0, bias_variance = kNaN, sd_variance = kNaN;
  if (result.persons > 1) {
    double between = 0.0;
    for (const DifferenceSums& p : persons)
      if (p.n > 0.0) between += p.n * std::pow(p.sum / p.n - result.bias, 2);
    between /= k - 1.0;
    const double each = (n * n - n2) / ((k - 1.0) * n);  // measurements of a person, as many as count
    between2 = std::max(0.0, (between - within2) / each);
    bias_variance = (between2 * n2 + within2 * n) / (n * n);
    const double variance = between2 + within2;
    const double of_between = between / each, of_within = (1.0 - 1.0 / each) * within2;
    const double squares =
        of_between * of_between / (k - 1.0) + (n > k ? of_within * of_within / (n - k) : 0.0);
    // var(sd) = sd^2 / (2 degrees of freedom), and these are variance^2 / squares
    sd_variance = variance > 0.0 ? squares / (2.0 * variance) : 0.0;
  }
  result.sd = std::sqrt(between2 + within2);
  result.lower = result.bias - kNormal95 * result.sd;
  result.upper = result.bias + kNormal95 * result.sd;
  const double t = student_quantile(result.persons - 1);
  const double of_bias = t * std::sqrt(bias_variance),
               of_limit = t * std::sqrt(bias_variance + kNormal95 * kNormal95 * sd_variance);
  result.bias_low = result.bias - of_bias;
  result.bias_high = result.bias + of_bias;
  result.lower_low = result.lower - of_limit;
  result.lower_high = result.lower + of_limit;
  result.upper_low = result.upper - of_limit;
  result.upper_high = result.upper + of_limit;
  return result;
}

}  // namespace trilat
