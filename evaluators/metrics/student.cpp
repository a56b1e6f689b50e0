// SPDX-License-Identifier: MIT
#include "evaluators/metrics/student.h"

#include <cmath>

#include <gsl/gsl_cdf.h>

#include "evaluators/solvers/point_estimate.h"

namespace trilat {

double student_quantile(std::size_t degrees, double alpha) {
  return gsl_cdf_tdist_Qinv(0.5 * alpha, static_cast<double>(degrees));
}

double student_two_sided(double t, std::size_t degrees) {
  if (std::isnan(t) || degrees == 0) return kNaN;
  return 2.0 * gsl_cdf_tdist_Q(std::abs(t), static_cast<double>(degrees));
}

}  // namespace trilat
