// SPDX-License-Identifier: MIT
#include "evaluators/solvers/sensor_plane.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace trilat {
namespace {

constexpr double kCollinearRatio = 1e-12;
constexpr double kCoplanarRatio = 1e-12;

// Measured by the offsets and not by the least eigenvalue, whose rounding hides whatever is within 1e-8 of
// the spread: enough to tell the two sides apart.
bool in_one_plane(const RangeProblem& problem, const SensorPlane& plane) {
  if (problem.count == 3) return true;
  double farthest_m = 0.0;
  for (int i = 0; i < problem.count; ++i)
    farthest_m = std::max(farthest_m, std::abs(plane.offset_m(problem.sensor_m[i])));
  return farthest_m <= kCoplanarRatio * std::sqrt(plane.scatter_m2[2]);
}

}  // namespace

SensorPlane plane_of(const RangeProblem& problem) {
  SensorPlane plane;
  for (int i = 0; i < problem.count; ++i) plane.centroid_m += problem.sensor_m[i] / problem.count;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (int i = 0; i < problem.count; ++i) {
    const Eigen::Vector3d s = problem.sensor_m[i] - plane.centroid_m;
    scatter += s * s.transpose();
  }
  plane.collinear = true;
  if (!scatter.allFinite()) return plane;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter);
  plane.axes = eigen.eigenvectors();
  plane.scatter_m2 = eigen.eigenvalues().cwiseMax(0.0);
  plane.collinear = !(plane.scatter_m2[1] > kCollinearRatio * plane.scatter_m2[2]);
  plane.exact = in_one_plane(problem, plane);
  return plane;
}

bool same_sensors(const RangeProblem& a, const RangeProblem& b) {
  return a.count == b.count &&
         std::equal(a.sensor_m.begin(), a.sensor_m.begin() + a.count, b.sensor_m.begin());
}

bool sensors_before(const RangeProblem& a, const RangeProblem& b) {
  if (a.count != b.count) return a.count < b.count;
  for (int i = 0; i < a.count; ++i)
    for (int axis = 0; axis < 3; ++axis)
      if (a.sensor_m[i][axis] != b.sensor_m[i][axis]) return a.sensor_m[i][axis] < b.sensor_m[i][axis];
  return false;
}

namespace {

constexpr double kMaxStartDistance = 2.0;  // of mean range and spread
constexpr double kMinStartOffset = 0.1;    // of the mean range
constexpr double kSameResidual_m = 1e-9;   // allows for rounding
constexpr int kBetween = 32;               // steps from one descent's end to the other's

double residual_rms_m(const RangeProblem& problem, double cost_m2) {
  return std::sqrt(cost_m2 / problem.count);
}

// Whether F rises between two points above its value at both: a coarse stop rule leaves two descents into one
// minimum apart.
bool are_two_minima(const RangeProblem& problem, const Eigen::Vector3d& one_m,
                    const Eigen::Vector3d& other_m) {
  const auto cost_m2 = [&](double share) {
    return linearise(problem, one_m + share * (other_m - one_m)).cost;
  };
  const double ends_m2 = std::max(cost_m2(0.0), cost_m2(1.0));
  for (int k = 1; k < kBetween; ++k)
    if (cost_m2(static_cast<double>(k) / kBetween) > ends_m2) return true;
  return false;
}

// Whether two minima on different sides of the plane fit equally well.
bool costs_do_not_decide(const RangeProblem& problem, const Descent& one, const Descent& other,
                         double range_sigma_m) {
  const double apart_m = std::abs(residual_rms_m(problem, one.cost) - residual_rms_m(problem, other.cost));
  return apart_m <= kSameResidual_m || (!ranges_decide(std::abs(one.cost - other.cost), range_sigma_m) &&
                                        are_two_minima(problem, one.position_m, other.position_m));
}

}  // namespace

Eigen::Vector3d plausible_start(const RangeProblem& problem, const SensorPlane& plane,
                                const Eigen::Vector3d& wanted_m) {
  double mean_range_m = 0.0;
  for (int i = 0; i < problem.count; ++i) mean_range_m += problem.range_m[i] / problem.count;
  const double spread_m = std::sqrt(plane.scatter_m2.sum() / problem.count);
  Eigen::Vector3d start = wanted_m;
  // !(a <= b) holds for NaN too.
  if (!((start - plane.centroid_m).norm() <= kMaxStartDistance * (mean_range_m + spread_m)))
    start = solve_squared_ranges(problem, plane);
  const double offset_m = plane.offset_m(start);
  const double least_m = kMinStartOffset * mean_range_m;
  if (std::abs(offset_m) < least_m) start += (std::copysign(least_m, offset_m) - offset_m) * plane.normal();
  return start;
}

Descent choose_minimum(const RangeProblem& problem, const SensorPlane& plane, const Descent& first,
                       const Descent& second, double range_sigma_m) {
  const int iterations = first.iterations + second.iterations;
  const bool both = is_usable(first.status) && is_usable(second.status);
  Descent chosen = is_usable(second.status) && !is_usable(first.status) ? second : first;
  if (both && (first.position_m - second.position_m).norm() > kSameMinimum_m) {
    const bool first_is_lower = first.cost < second.cost;
    chosen = first_is_lower ? first : second;
    const bool one_side = plane.offset_m(first.position_m) * plane.offset_m(second.position_m) > 0.0;
    if (!one_side && costs_do_not_decide(problem, first, second, range_sigma_m)) {
      const MirrorChoice choice = choose_mirror(first.position_m, second.position_m, problem.guess_m);
      if (choice.decided)
        chosen = choice.first ? first : second;
      else
        chosen.status = SolveStatus::mirror_ambiguous;
    }
  }
  chosen.iterations = iterations;
  return chosen;
}

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
