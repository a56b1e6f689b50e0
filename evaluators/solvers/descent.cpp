// SPDX-License-Identifier: MIT
#include "evaluators/solvers/descent.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "datasets/base/error.h"

namespace trilat {
namespace {

using Eigen::Vector3d;

// Sums go by x, y, z, as in range_lanes.cpp, which gives the same bits.
double dot(const Vector3d& a, const Vector3d& b) { return a.x() * b.x() + a.y() * b.y() + a.z() * b.z(); }

bool objective_rule_holds(const DescentOptions& options, double change_m2) {
  if (options.stop == StopRule::printed) return change_m2 < options.threshold_m2;  // erratum E8
  return options.stop == StopRule::objective && std::abs(change_m2) < options.threshold_m2;
}

bool step_rule_holds(const DescentOptions& options, const Vector3d& step_m) {
  return options.stop == StopRule::step &&
         dot(step_m, step_m) < options.step_tolerance_m * options.step_tolerance_m;
}

// The step that solves matrix * step = -gradient, by the adjugate inverse of eq. 18.
Vector3d step_of(const Symmetric3& adjugate, double determinant, const Vector3d& gradient) {
  return (adjugate * gradient) * (-1.0 / determinant);
}

// x_{k+1} = x_k - (J^T J)^-1 J^T f, eq. 14.
Descent descend_undamped(const RangeProblem& problem, const Vector3d& start_m,
                         const DescentOptions& options) {
  Descent now{start_m, SolveStatus::not_solved, 0, kNaN};
  Vector3d step_m = Vector3d::Constant(std::numeric_limits<double>::infinity());
  double before_m2 = -std::numeric_limits<double>::infinity();
  while (true) {
    const RangeEquations here = linearise(problem, now.position_m, options, Curvature::gauss_newton);
    now.cost_m2 = here.cost_m2;
    const Symmetric3 adjugate = here.matrix.adjugate();
    const double determinant = here.matrix.determinant(adjugate);
    if (!std::isfinite(here.cost_m2))
      now.status = SolveStatus::diverged;
    else if (step_rule_holds(options, step_m) || objective_rule_holds(options, here.cost_m2 - before_m2))
      now.status = SolveStatus::converged;
    else if (now.iterations == options.max_iterations)
      now.status = SolveStatus::iteration_limit;
    else if (is_rank_deficient(here.matrix, adjugate, determinant))
      now.status = SolveStatus::rank_deficient;
    if (now.status != SolveStatus::not_solved) return now;
    step_m = step_of(adjugate, determinant, here.gradient);
    now.position_m += step_m;
    before_m2 = here.cost_m2;
    ++now.iterations;
  }
}

// The factor on the damping after a step that lowered F by `gained` of the `predicted`: it falls fast while
// the linearisation predicts F well and stays while it just does.
double damping_factor(double gained, double predicted) {
  if (std::abs(gained - predicted) < 0.1 * predicted) return 0.05;
  if (gained > 0.75 * predicted) return 1.0 / 3.0;
  return gained > 0.25 * predicted ? 1.0 : 2.0;
}

// The leading minors.
bool is_positive_definite(const Symmetric3& matrix, const Symmetric3& adjugate, double determinant) {
  return matrix.xx > 0.0 && adjugate.zz > 0.0 && determinant > 0.0;
}

// (J^T J + lambda I) step = -J^T f, or with the Hessian in place of J^T J. A step that raises F, or a matrix
// that is not positive definite, is taken back and tried again with more damping.
Descent descend_damped(const RangeProblem& problem, const Vector3d& start_m, const DescentOptions& options) {
  constexpr double kRounding = 4e-15;  // of the grain: a smaller change of F is rounding
  // Damping below which newton uses the whole Hessian: Gauss-Newton has then predicted F well. Farther off
  // the Hessian is indefinite, and its steps may leave for another minimum.
  constexpr double kTrusted = 2e-5;
  Curvature curvature = Curvature::gauss_newton;
  RangeEquations here = linearise(problem, start_m, options, curvature);
  Descent now{start_m, SolveStatus::iteration_limit, 0, here.cost_m2};
  if (!std::isfinite(here.cost_m2)) now.status = SolveStatus::diverged;
  double damping = 1e-4, growth = 2.0;  // damping: share of the trace of J^T J
  while (now.status == SolveStatus::iteration_limit && now.iterations < options.max_iterations) {
    ++now.iterations;
    const double lambda = damping * problem.count;
    Symmetric3 damped = here.matrix;
    damped.add_to_diagonal(lambda);
    const Symmetric3 adjugate = damped.adjugate();
    const double determinant = damped.determinant(adjugate);
    const bool is_sound =
        options.curvature == Curvature::gauss_newton || is_positive_definite(damped, adjugate, determinant);
    const Vector3d step_m = step_of(adjugate, determinant, here.gradient);
    const Vector3d there_m = now.position_m + step_m;
    if (is_sound && step_rule_holds(options, step_m)) {  // the last step is taken unseen
      now.position_m = there_m;
      now.status = SolveStatus::converged;
      break;
    }
    const RangeEquations there = linearise(problem, there_m, options, curvature);
    double gained = here.cost_m2 - there.cost_m2;
    double predicted = lambda * dot(step_m, step_m) - dot(step_m, here.gradient);
    // Also where the step is not taken: at the minimum itself none is.
    if (is_sound && objective_rule_holds(options, -gained)) now.status = SolveStatus::converged;
    // Near the minimum F says nothing any more, and the gradient takes its place.
    if (std::abs(gained) <= kRounding * here.grain_m2) {
      predicted = dot(here.gradient, here.gradient);
      gained = predicted - dot(there.gradient, there.gradient);
    }
    const bool is_taken = is_sound && gained > 0.0;
    damping *= is_taken ? damping_factor(gained, predicted) : growth;
    growth = is_taken ? 2.0 : 2.0 * growth;
    if (options.curvature == Curvature::newton)
      curvature = damping < kTrusted ? Curvature::newton : Curvature::gauss_newton;
    if (!is_taken) continue;
    now.position_m = there_m;
    now.cost_m2 = there.cost_m2;
    here = there;
  }
  return now;
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

RangeEquations linearise(const RangeProblem& problem, const Vector3d& x_m, const DescentOptions& options,
                         Curvature curvature) {
  RangeEquations sum{{}, Vector3d::Zero()};
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
    sum.cost_m2 += f * f;
    sum.grain_m2 += std::abs(f) * distance;
    sum.gradient += slope * v;
    sum.matrix.add_outer(q, v);
  }
  if (curvature == Curvature::newton) sum.matrix.add_to_diagonal(bend);
  return sum;
}

RangeEquations linearise(const RangeProblem& problem, const Vector3d& x_m) {
  return linearise(problem, x_m, {}, Curvature::gauss_newton);
}

Descent descend(const RangeProblem& problem, const Vector3d& start_m, const DescentOptions& options) {
  TRILAT_CHECK(contradiction_in(options).empty(), "the settings of a descent fit together");
  return options.damping == Damping::none ? descend_undamped(problem, start_m, options)
                                          : descend_damped(problem, start_m, options);
}

PointEstimate estimate_at(const RangeProblem& problem, const Vector3d& x_m, SolveStatus status,
                          int iterations) {
  PointEstimate result;
  result.position_m = x_m;
  result.status = status;
  result.iterations = iterations;
  const RangeEquations equations = linearise(problem, x_m);
  result.cost_m2 = equations.cost_m2;
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
