// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include <Eigen/Core>

#include "evaluators/solvers/point_estimate.h"
#include "evaluators/solvers/range_problem.h"
#include "evaluators/solvers/symmetric3.h"

namespace trilat {

// Directions count as not spanning space when gdop^2 * sum of weights > 1 / kRankRatio, which
// bounds the ratio of the smallest to the largest eigenvalue of J^T W J within a factor of 9. At 2
// m from sensors in one plane that is a joint within about 30 um of the plane.
inline constexpr double kRankRatio = 1e-10;

// Nearer than this to a sensor the direction to it is rounding: its row of J shrinks to zero.
inline constexpr double kOnSensor_m = 1e-12;

// F = sum w f^2, f = |x - s| - r, and its linearisation at x: rows of J are the unit vectors from
// the sensors. Metres.
struct RangeEquations {
  Symmetric3 normal;         // J^T W J
  Eigen::Vector3d gradient;  // J^T W f, half the derivative of F
  double cost_m2;            // F
};

// A problem laid out for linearising many times: coordinates by axis and two sensors at a time. An
// odd count is filled up with a sensor of weight 0.
struct PackedRanges {
  int pairs = 0;
  std::array<Eigen::Array2d, kMaxSensors / 2> x_m, y_m, z_m, range_m, weight;
};
PackedRanges packed(const RangeProblem& problem);

RangeEquations linearise(const PackedRanges& ranges, const Eigen::Vector3d& x_m);

// The same with the right-hand side of eq. 17 as printed (erratum E7): (x - s) f over the squared
// distance, every length counted in `unit_m`, and the result given in metres. It is J^T W f with
// each row scaled by unit / distance, so the step depends on the unit.
RangeEquations linearise_as_printed(const PackedRanges& ranges, const Eigen::Vector3d& x_m,
                                    double unit_m);

// `determinant` and `adjugate` are those of `normal`.
bool is_rank_deficient(const Symmetric3& normal, const Symmetric3& adjugate, double determinant);

// The estimate at x with cost, gdop and covariance filled in.
[[nodiscard]] PointEstimate estimate_at(const RangeProblem& problem, const Eigen::Vector3d& x_m,
                                        SolveStatus status, int iterations);

}  // namespace trilat
