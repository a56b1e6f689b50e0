// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include <Eigen/Core>

#include "evaluators/solvers/point_estimate.h"
#include "evaluators/solvers/range_problem.h"
#include "evaluators/solvers/sensor_plane.h"
#include "evaluators/solvers/symmetric3.h"

namespace trilat {

// Directions count as not spanning space when gdop^2 * number of sensors > 1 / kRankRatio, which bounds the
// ratio of the smallest to the largest eigenvalue of J^T J within a factor of 9. At 2 m from sensors in one
// plane that is a joint within about 30 um of the plane.
inline constexpr double kRankRatio = 1e-10;

// Nearer than this to a sensor the direction to it is rounding: its row of J shrinks to zero.
inline constexpr double kOnSensor_m = 1e-12;

// F = sum f^2, f = |x - s| - r, and its linearisation at x: rows of J are the unit vectors from the
// sensors. Metres.
struct RangeEquations {
  Symmetric3 normal;         // J^T J
  Eigen::Vector3d gradient;  // J^T f, half the derivative of F
  double cost_m2;            // F
};

// A problem laid out for linearising many times: coordinates by axis and two sensors at a time. An odd count
// is filled up with a sensor of weight 0; all others have 1.
struct PackedRanges {
  int pairs = 0;
  std::array<Eigen::Array2d, kMaxSensors / 2> x_m, y_m, z_m, range_m, weight;
};
PackedRanges packed(const RangeProblem& problem);

[[gnu::always_inline]] inline RangeEquations linearise(const PackedRanges& ranges,
                                                       const Eigen::Vector3d& x_m) {
  using Eigen::Array2d;
  const Array2d zero = Array2d::Zero();
  Array2d xx = zero, xy = zero, xz = zero, yy = zero, yz = zero, zz = zero;
  Array2d gx = zero, gy = zero, gz = zero, cost = zero;
  for (int p = 0; p < ranges.pairs; ++p) {
    const Array2d x = x_m.x() - ranges.x_m[p];
    const Array2d y = x_m.y() - ranges.y_m[p];
    const Array2d z = x_m.z() - ranges.z_m[p];
    const Array2d square = x * x + y * y + z * z;
    // The quotient does not wait for the root, which shortens the chain of each iteration.
    const Array2d w_over_square = ranges.weight[p] / square.max(kOnSensor_m * kOnSensor_m);
    const Array2d distance = square.sqrt();
    const Array2d f = distance - ranges.range_m[p];
    cost += ranges.weight[p] * f * f;
    const Array2d qx = w_over_square * x;
    const Array2d qy = w_over_square * y;
    const Array2d qz = w_over_square * z;
    xx += qx * x;
    xy += qx * y;
    xz += qx * z;
    yy += qy * y;
    yz += qy * z;
    zz += qz * z;
    const Array2d right = distance * f;
    gx += qx * right;
    gy += qy * right;
    gz += qz * right;
  }
  return {{xx.sum(), xy.sum(), xz.sum(), yy.sum(), yz.sum(), zz.sum()},
          {gx.sum(), gy.sum(), gz.sum()},
          cost.sum()};
}

// `determinant` and `adjugate` are those of `normal`.
inline bool is_rank_deficient(const Symmetric3& normal, const Symmetric3& adjugate, double determinant) {
  const double trace = normal.trace();
  const double pairs = adjugate.trace();
  // Negated, so that NaN counts as deficient.
  return !(pairs > kRankRatio * trace * trace && determinant > kRankRatio * trace * pairs);
}

// The estimate at x with cost, gdop (infinite where the directions do not span space) and covariance, the
// Cramer-Rao bound (J^T J)^-1 of ranges with variance 1 (NaN where gdop is infinite).
[[nodiscard]] PointEstimate estimate_at(const RangeProblem& problem, const Eigen::Vector3d& x_m,
                                        SolveStatus status, int iterations);

// The exact global minimum of sum (|x - s|^2 - r^2)^2, for any number of sensors from three on and also when
// they stand in one plane (Beck, Stoica and Li, "Exact and approximate solutions of source localization
// problems", IEEE Trans. Signal Processing 56(5), 2008: a quadratic problem with one quadratic constraint,
// whose multiplier is the one root of a decreasing function). With x = centroid + axes y and multiplier mu it
// is y_j = c_j / (4 scatter_j + mu). When the sensors stand in one plane there are two, mirror images of each
// other; this is the one on the side of the plane's normal. `plane` is that of the
// problem, not collinear.
Eigen::Vector3d squared_range_position_m(const RangeProblem& problem, const SensorPlane& plane);

}  // namespace trilat
