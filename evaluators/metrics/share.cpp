// SPDX-License-Identifier: MIT
#include "evaluators/metrics/share.h"

#include <algorithm>
#include <cmath>

#include <gsl/gsl_cdf.h>

#include "evaluators/metrics/cluster_ratios.h"
#include "evaluators/metrics/student.h"

namespace trilat {
namespace {

// What is not exceeded with this probability. GSL's own inverse fails for large a and b, so the distribution
// itself is inverted: halving ends at two neighbouring numbers.
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
  const ContrastEstimate mean = solve_contrast({{{successes, samples}}, {}});
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

}  // namespace trilat
