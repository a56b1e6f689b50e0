// SPDX-License-Identifier: MIT
#include "evaluators/solvers/squared_ranges.h"

#include <algorithm>
#include <cmath>

namespace trilat {
namespace {

constexpr int kMaxSteps = 60;
constexpr double kRootTolerance = 1e-13;

// phi(mu) = sum_j c_j^2 / (gap_j + mu)^2 - level - mu / (2 n), with gap_0 = 0 the least: convex and
// decreasing for mu > 0. mu is the multiplier counted from the pole of the first axis.
struct Secular {
  Eigen::Array3d square;  // c_j^2
  Eigen::Array3d gap;
  double level;
  double slope;  // 1 / (2 n)

  double value(double mu) const { return (square / (gap + mu).square()).sum() - level - slope * mu; }
  double derivative(double mu) const { return -2.0 * (square / (gap + mu).cube()).sum() - slope; }
  // The terms that stay finite at the pole.
  double rest() const { return square[1] / (gap[1] * gap[1]) + square[2] / (gap[2] * gap[2]) - level; }
};

// The root of phi above 0. Newton's method from the left of the root of a convex decreasing function never
// oversteps it; from the right it lands on the left of it, or beyond the pole and is halved.
double root_of(const Secular& phi, double guess) {
  double mu = guess;
  for (int i = 0; i < kMaxSteps; ++i) {
    double next = mu - phi.value(mu) / phi.derivative(mu);
    if (!(next > 0.0)) next = 0.5 * mu;
    const double change = std::abs(next - mu);
    mu = next;
    if (!(change > kRootTolerance * mu)) break;
  }
  return mu;
}

}  // namespace

Eigen::Vector3d solve_squared_ranges(const RangeProblem& problem, const SensorPlane& plane) {
  const double n = problem.count;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  double total = 0.0;
  for (int i = 0; i < problem.count; ++i) {
    const Eigen::Vector3d s = problem.sensor_m[i] - plane.centroid_m;
    const double b = problem.range_m[i] * problem.range_m[i] - s.squaredNorm();
    moment -= 2.0 * b * s;
    total += b;
  }
  const Eigen::Array3d c = (plane.axes.transpose() * moment).array();
  const Eigen::Array3d four = 4.0 * plane.scatter_m2.array();
  Secular phi{c.square(), four - four[0], (total - 0.5 * four[0]) / n, 0.5 / n};
  const double rest = phi.rest();
  const double scale = plane.scatter_m2[2];
  Eigen::Array3d y;
  if (plane.exact && rest <= 0.0) {  // the pole's own term vanishes: both sides fit alike
    y = {std::sqrt(-rest), c[1] / phi.gap[1], c[2] / phi.gap[2]};
  } else {
    if (plane.exact) phi.square[0] = 0.0;
    const double guess = rest < 0.0 ? std::abs(c[0]) / std::sqrt(-rest) : scale;
    const double mu = root_of(phi, std::max(guess, 1e-12 * scale));
    y = c / (phi.gap + mu);
    if (plane.exact) y[0] = 0.0;
  }
  return plane.centroid_m + plane.axes * y.matrix();
}

}  // namespace trilat
