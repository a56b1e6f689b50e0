// SPDX-License-Identifier: MIT
#include "evaluators/metrics/student.h"

#include <cmath>

#include <gsl/gsl_cdf.h>

#include "evaluators/solvers/point_estimate.h"

namespace trilat {
namespace {

// The continued fraction of the incomplete beta function (Abramowitz and Stegun 26.5.8) by Lentz's method.
double beta_fraction(double a, double b, double x) {
  constexpr double kTiny = 1e-300, kEnough = 1e-15;
  constexpr int kMost = 10'000;
  const auto not_zero = [](double value) { return std::abs(value) < kTiny ? kTiny : value; };
  double c = 1.0, d = 1.0 / not_zero(1.0 - (a + b) * x / (a + 1.0)), fraction = d;
  for (int i = 1; i < kMost; ++i) {
    const double m = i;
    const double even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
    double step = 1.0;
    for (const double term : {even, odd}) {
      d = 1.0 / not_zero(1.0 + term * d);
      c = not_zero(1.0 + term / c);
      step = c * d;
      fraction *= step;
    }
    if (std::abs(step - 1.0) < kEnough) break;
  }
  return fraction;
}

// The regularised incomplete beta function I_x(a, b); `y` is 1 - x.
double incomplete_beta(double a, double b, double x, double y) {
  if (x <= 0.0) return 0.0;
  if (y <= 0.0) return 1.0;
  const double front =
      std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log(y));
  if (x < (a + 1.0) / (a + b + 2.0)) return front * beta_fraction(a, b, x) / a;
  return 1.0 - front * beta_fraction(b, a, y) / b;
}

}  // namespace

double student_quantile(std::size_t degrees, double alpha) {
  return gsl_cdf_tdist_Qinv(0.5 * alpha, static_cast<double>(degrees));
}

double student_two_sided(double t, std::size_t degrees) {
  if (std::isnan(t) || degrees == 0) return kNaN;
  if (std::isinf(t)) return 0.0;
  const auto n = static_cast<double>(degrees);
  const double whole = n + t * t;
  return incomplete_beta(n / 2.0, 0.5, n / whole, t * t / whole);
}

}  // namespace trilat
