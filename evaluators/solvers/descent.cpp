// SPDX-License-Identifier: MIT
#include "evaluators/solvers/descent.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "datasets/base/error.h"

namespace trilat {
namespace {

using Eigen::Vector3d;

// x_{k+1} = x_k - (J^T J)^-1 J^T f, eq. 14.
Descent descend_undamped(const RangeProblem& problem, const Vector3d& start_m,
                         const DescentOptions& options) {
  Descent now{start_m, SolveStatus::not_solved, 0, kNaN};
  Vector3d step_m = Vector3d::Constant(std::numeric_limits<double>::infinity());
  double before_m2 = -std::numeric_limits<double>::infinity();
  while (true) {
    const Linearised here = linearise(problem, now.position_m, options, Curvature::gauss_newton);
    now.cost = here.cost;
    const Symmetric3 adjugate = here.matrix.adjugate();
    const double determinant = here.matrix.determinant(adjugate);
    if (!std::isfinite(here.cost))
      now.status = SolveStatus::diverged;
    else if (step_rule_holds(options, step_m) || objective_rule_holds(options, here.cost - before_m2))
      now.status = SolveStatus::converged;
    else if (now.iterations == options.max_iterations)
      now.status = SolveStatus::iteration_limit;
    else if (is_rank_deficient(here.matrix, adjugate, determinant))
      now.status = SolveStatus::rank_deficient;
    if (now.status != SolveStatus::not_solved) return now;
    step_m = step_of(adjugate, determinant, here.gradient);
    now.position_m += step_m;
    before_m2 = here.cost;
    ++now.iterations;
  }
}

}  // namespace

std::string contradiction_in(const DescentOptions& options) {
  if (options.gradient == Gradient::printed) {
    if (options.damping == Damping::lm)
      return "lm needs the corrected gradient: the printed one is not a gradient of the cost";
    if (options.curvature == Curvature::newton) return "newton needs the corrected gradient";
  }
  if (options.damping == Damping::none && options.curvature == Curvature::newton)
    return "newton needs damping lm: away from the minimum the Hessian may point uphill";
  return {};
}

Linearised linearise(const RangeProblem& problem, const Vector3d& x_m, const DescentOptions& options,
                     Curvature curvature) {
  Linearised sum{{}, Vector3d::Zero()};
  double bend = 0.0;  // sum of 1 - r/d
  for (int i = 0; i < problem.count; ++i) {
    const Vector3d v = x_m - problem.sensor_m[i];
    const double square = dot(v, v);
    const double distance = std::sqrt(square);
    const double f = distance - problem.range_m[i];
    const double inverse = 1.0 / std::max(square, kOnSensor_m * kOnSensor_m);
    const double slope =
        inverse * ((options.gradient == Gradient::printed ? options.printed_unit_m : distance) * f);
    double q = inverse;
    if (curvature == Curvature::newton) {
      bend += slope;
      q -= slope * inverse;
    }
    sum.cost += f * f;
    sum.rounding_scale += std::abs(f) * distance;
    sum.gradient += slope * v;
    sum.matrix.add_outer(q, v);
  }
  if (curvature == Curvature::newton) sum.matrix.add_to_diagonal(bend);
  return sum;
}

Linearised linearise(const RangeProblem& problem, const Vector3d& x_m) {
  return linearise(problem, x_m, {}, Curvature::gauss_newton);
}

Descent descend(const RangeProblem& problem, const Vector3d& start_m, const DescentOptions& options) {
  TRILAT_CHECK(contradiction_in(options).empty(), "the settings of a descent fit together");
  if (options.damping == Damping::none) return descend_undamped(problem, start_m, options);
  return minimise(
      [&](const Vector3d& x_m, Curvature curvature) { return linearise(problem, x_m, options, curvature); },
      start_m, problem.count, options);  // the trace of J^T J is the number of sensors
}

PointEstimate estimate_at(const RangeProblem& problem, const Vector3d& x_m, SolveStatus status,
                          int iterations) {
  PointEstimate result;
  result.position_m = x_m;
  result.status = status;
  result.iterations = iterations;
  const Linearised equations = linearise(problem, x_m);
  result.cost_m2 = equations.cost;
  const Symmetric3 adjugate = equations.matrix.adjugate();
  const double determinant = equations.matrix.determinant(adjugate);
  result.gdop = std::numeric_limits<double>::infinity();
  if (is_rank_deficient(equations.matrix, adjugate, determinant)) return result;
  result.gdop = std::sqrt(adjugate.trace() / determinant);
  result.covariance = adjugate.matrix() / determinant;
  return result;
}

PointEstimate estimate_of(const RangeProblem& problem, const Descent& descent) {
  PointEstimate failure = failed_estimate(descent.status);
  failure.iterations = descent.iterations;
  if (descent.status == SolveStatus::diverged) return failure;
  PointEstimate result = estimate_at(problem, descent.position_m, descent.status, descent.iterations);
  if (!std::isfinite(result.gdop) && result.status != SolveStatus::iteration_limit)
    result.status = SolveStatus::rank_deficient;
  return result;
}

}  // namespace trilat
