// SPDX-License-Identifier: MIT
#pragma once

#include "evaluators/solvers/nonlinear.h"
#include "evaluators/solvers/point_estimate.h"
#include "evaluators/solvers/range_problem.h"
#include "evaluators/solvers/sensor_plane.h"

namespace trilat {

struct CeresOptions {
  double function_tolerance = 1e-16;   // |F_k - F_{k-1}| < tolerance * F
  double gradient_tolerance = 1e-20;   // max |dF/dx| < tolerance
  double parameter_tolerance = 1e-13;  // |x_k - x_{k-1}| < tolerance * |x|
  int max_iterations = 1000;           // of each descent
  Start start = Start::squared_ranges;
  Eigen::Vector3d start_point_m = Eigen::Vector3d::Constant(kNaN);
  LinearOptions linear;  // of the linear start
  double range_sigma_m = kUsualRangeSigma_m;
};

// The cost, starts, choice between two solutions and statuses of solve_nonlinear() with lm, but minimised by
// Ceres (Levenberg-Marquardt, dense QR, analytic derivatives, one thread): an independent second opinion.
[[nodiscard]] PointEstimate solve_ceres(const RangeProblem& problem, const CeresOptions& options);

// One descent of it from one start. The start of the options does not count.
[[nodiscard]] Descent descend_by_ceres(const RangeProblem& problem, const CeresOptions& options,
                                       const Eigen::Vector3d& start_m);

}  // namespace trilat
