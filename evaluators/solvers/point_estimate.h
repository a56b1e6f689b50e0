// SPDX-License-Identifier: MIT
#pragma once

#include <limits>

#include <Eigen/Core>

#include "evaluators/solvers/solve_status.h"

namespace trilat {

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// Where a method puts a joint in the world. Ask is_usable(status) before using the position: it is
// also filled for iteration_limit (the last iterate), mirror_ambiguous (one of the two) and for
// rank_deficient when a descent ended there, so that a failure can be looked at, and NaN for every
// other failure.
struct PointEstimate {
  Eigen::Vector3d position_m = Eigen::Vector3d::Constant(kNaN);
  SolveStatus status = SolveStatus::not_solved;
  int iterations = 0;     // steps tried, of all starts together
  double cost_m2 = kNaN;  // sum of weight * (|x - sensor| - range)^2
  // Of the geometry at the position, whatever the method: sqrt(trace((U^T U)^-1)), U's rows the
  // unit vectors from the sensors; infinite when they do not span space, NaN without ranges.
  double gdop = kNaN;
  // (U^T W U)^-1, the Cramer-Rao bound of unbiased normal ranges: m^2 when weights are inverse
  // variances in 1/m^2, and times the range variance when they are 1. NaN when gdop is not finite.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Constant(kNaN);
};

inline PointEstimate failed_estimate(SolveStatus status) {
  PointEstimate result;
  result.status = status;
  return result;
}

}  // namespace trilat
