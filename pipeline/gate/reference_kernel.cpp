// SPDX-License-Identifier: MIT
#include "pipeline/gate/reference_kernel.h"

#include <cmath>

namespace trilat {
namespace {

double determinant(const double (&a)[3][3]) {
  return a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) -
         a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0]) +
         a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
}

void step(const ReferenceProblem& p, double (&x)[3]) {
  double normal[3][3] = {}, right[3] = {};
  for (int s = 0; s < 4; ++s) {
    double away[3], squared = 0.0;
    for (int i = 0; i < 3; ++i) {
      away[i] = x[i] - p.sensor_m[s][i];
      squared += away[i] * away[i];
    }
    const double distance = std::sqrt(squared), residual = distance - p.range_m[s];
    for (int i = 0; i < 3; ++i) {
      right[i] -= away[i] / distance * residual;
      for (int j = 0; j < 3; ++j) normal[i][j] += away[i] * away[j] / squared;
    }
  }
  const double whole = determinant(normal);
  for (int i = 0; i < 3; ++i) {
    double replaced[3][3];
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) replaced[r][c] = c == i ? right[r] : normal[r][c];
    x[i] += determinant(replaced) / whole;
  }
}

}  // namespace

double solve_reference(std::span<const ReferenceProblem> problems) {
  constexpr int kSteps = 6;
  double sum = 0.0;
  for (const ReferenceProblem& p : problems) {
    double x[3] = {};
    for (const auto& sensor : p.sensor_m)
      for (int i = 0; i < 3; ++i) x[i] += 0.25 * sensor[i];
    for (int k = 0; k < kSteps; ++k) step(p, x);
    sum += x[0] + x[1] + x[2];
  }
  return sum;
}

}  // namespace trilat
