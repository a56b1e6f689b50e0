// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <limits>
#include <span>

#include <Eigen/Core>

#include "evaluators/solvers/point_estimate.h"
#include "evaluators/solvers/range_equations.h"
#include "evaluators/solvers/range_problem.h"
#include "evaluators/solvers/symmetric3.h"

namespace trilat {

// What the geometry at a position allows, whatever the method. U's rows are the unit vectors from the
// sensors.
struct Precision {
  // The diagonal of (U^T U)^-1: the variances along the world's axes when every range has variance 1.
  // Infinite when the directions do not span space.
  Eigen::Vector3d unit_variance = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  double gdop = std::numeric_limits<double>::infinity();  // root of its sum
  // The Cramer-Rao bound (U^T V^-1 U)^-1 of unbiased estimates of the position, V the variances of
  // independent normal range errors. NaN when gdop is infinite.
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Constant(kNaN);
};

// From U^T U and U^T V^-1 U.
inline Precision precision_of(const Symmetric3& directions, const Symmetric3& information) {
  Precision result;
  const Symmetric3 adjugate = directions.adjugate();
  const double determinant = directions.determinant(adjugate);
  if (is_rank_deficient(directions, adjugate, determinant)) return result;
  result.gdop = std::sqrt(adjugate.trace() / determinant);
  result.unit_variance = Eigen::Vector3d(adjugate.xx, adjugate.yy, adjugate.zz) / determinant;
  const Symmetric3 inverse = information.adjugate();
  result.covariance_m2 = inverse.matrix() / information.determinant(inverse);
  return result;
}

// At x, with a variance for each of the problem's ranges, > 0; its ranges and weights are not read.
[[nodiscard]] Precision precision_at(const RangeProblem& problem, const Eigen::Vector3d& x_m,
                                     std::span<const double> range_variance_m2);

// The same when sensor i stands where the problem says only up to a normal error of the i-th covariance,
// independent of the others and of the ranges. Sensor positions are then unknowns with a normal prior; since
// each enters one range only, through -u, eliminating it leaves that range with the variance sigma^2 + u^T
// Sigma u. A range may be exact when its sensor is uncertain along u.
[[nodiscard]] Precision precision_at(const RangeProblem& problem, const Eigen::Vector3d& x_m,
                                     std::span<const double> range_variance_m2,
                                     std::span<const Eigen::Matrix3d> sensor_covariance_m2);

}  // namespace trilat
