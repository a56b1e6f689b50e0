// SPDX-License-Identifier: MIT
#include "evaluators/metrics/student.h"

#include <algorithm>
#include <cmath>

#include <gsl/gsl_cdf.h>
#include <gsl/gsl_errno.h>

#include "datasets/base/error.h"
#include "evaluators/solvers/point_estimate.h"

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

}  // namespace trilat
