// SPDX-License-Identifier: MIT
#include "evaluators/metrics/agreement.h"

#include <algorithm>
#include <cmath>

#include "evaluators/metrics/statistics.h"

namespace trilat {

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
