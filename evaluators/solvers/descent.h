// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "evaluators/solvers/descent_options.h"
#include "evaluators/solvers/minimise.h"
#include "evaluators/solvers/point_estimate.h"
#include "evaluators/solvers/range_problem.h"
#include "evaluators/solvers/symmetric3.h"

namespace trilat {

// Nearer than this to a sensor the direction to it is rounding: its row of J shrinks to zero.
inline constexpr double kOnSensor_m = 1e-12;

// F = sum f^2, f = |x - s| - r (eq. 10), in m^2, and its linearisation at x: rows of J are the unit vectors u
// from the sensors. By the options' gradient, which eq. 17 prints otherwise; `curvature` says whether the
// matrix is the whole Hessian.
Linearised linearise(const RangeProblem& problem, const Eigen::Vector3d& x_m, const DescentOptions& options,
                     Curvature curvature);
// J^T J, J^T f and F.
Linearised linearise(const RangeProblem& problem, const Eigen::Vector3d& x_m);

// Directions count as not spanning space when gdop^2 * number of sensors > 1 / kRankRatio, which bounds the
// ratio of the smallest to the largest eigenvalue of J^T J within a factor of 9. At 2 m from sensors in one
// plane that is a joint within about 30 um of the plane.
inline constexpr double kRankRatio = 1e-10;

// `determinant` and `adjugate` are those of `normal`, J^T J. NaN counts as deficient.
inline bool is_rank_deficient(const Symmetric3& normal, const Symmetric3& adjugate, double determinant) {
  const double trace = normal.trace();
  const double pairs = adjugate.trace();
  return !(pairs > kRankRatio * trace * trace && determinant > kRankRatio * trace * pairs);
}

// Minimises F from a start. Ends with
//   converged        the stop rule held
//   rank_deficient   is_rank_deficient() of J^T J at an iterate (without damping only)
//   iteration_limit  max_iterations steps were tried
//   diverged         F at an iterate is not finite
// With damping as minimise(). InternalError when contradiction_in(options).
[[nodiscard]] Descent descend(const RangeProblem& problem, const Eigen::Vector3d& start_m,
                              const DescentOptions& options);

// The estimate at x with cost, gdop (infinite where the directions do not span space) and covariance, the
// Cramer-Rao bound (J^T J)^-1 of ranges with variance 1 (NaN where gdop is infinite).
[[nodiscard]] PointEstimate estimate_at(const RangeProblem& problem, const Eigen::Vector3d& x_m,
                                        SolveStatus status, int iterations);

// The end of a descent with its geometry; rank_deficient when the directions do not span space there.
[[nodiscard]] PointEstimate estimate_of(const RangeProblem& problem, const Descent& descent);

}  // namespace trilat
