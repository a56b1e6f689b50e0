// SPDX-License-Identifier: MIT
#include "evaluators/solvers/nonlinear.h"

#include <cmath>

#include "datasets/base/check.h"
#include "evaluators/solvers/both_sides.h"
#include "evaluators/solvers/range_equations.h"

namespace trilat {
namespace {

constexpr double kFirstDamping = 1e-4;  // of the sum of weights, which is the trace of J^T W J
constexpr double kDampingFactor = 10.0;

RangeEquations equations_at(const RangeProblem& problem, const NonlinearOptions& options,
                            const Eigen::Vector3d& x_m) {
  return options.gradient == Gradient::printed ? linearise_as_printed(problem, x_m, options.printed_unit_m)
                                               : linearise(problem, x_m);
}

bool objective_rule_holds(const NonlinearOptions& options, double cost_m2, double previous_m2) {
  const double change_m2 = cost_m2 - previous_m2;
  if (options.stop == StopRule::printed) return change_m2 < options.threshold_m2;
  return options.stop == StopRule::objective && std::abs(change_m2) < options.threshold_m2;
}

bool step_rule_holds(const NonlinearOptions& options, const Eigen::Vector3d& step_m) {
  return options.stop == StopRule::step &&
         step_m.squaredNorm() < options.step_tolerance_m * options.step_tolerance_m;
}

// R_{k+1} = R_k - (J^T J)^-1 J^T f, eq. 14, with the adjugate inverse of eq. 18.
Descent descend_undamped(const RangeProblem& problem, const NonlinearOptions& options,
                         const Eigen::Vector3d& start_m) {
  Descent now{start_m, SolveStatus::iteration_limit, 0, kNaN};
  RangeEquations equations = equations_at(problem, options, start_m);
  now.cost_m2 = equations.cost_m2;
  while (now.iterations < options.max_iterations) {
    const Symmetric3 adjugate = equations.normal.adjugate();
    const double determinant = equations.normal.determinant(adjugate);
    if (is_rank_deficient(equations.normal, adjugate, determinant)) {
      now.status = SolveStatus::rank_deficient;
      return now;
    }
    const Eigen::Vector3d step_m = (adjugate * equations.gradient) * (-1.0 / determinant);
    const double previous_m2 = now.cost_m2;
    now.position_m += step_m;
    ++now.iterations;
    equations = equations_at(problem, options, now.position_m);
    now.cost_m2 = equations.cost_m2;
    if (!std::isfinite(now.cost_m2)) {
      now.status = SolveStatus::diverged;
      return now;
    }
    if (objective_rule_holds(options, now.cost_m2, previous_m2) || step_rule_holds(options, step_m)) {
      now.status = SolveStatus::converged;
      return now;
    }
  }
  return now;
}

// (J^T W J + lambda sum(w) I) step = -J^T W f; a step that raises F is taken back and tried again
// with more damping, so F never rises and a rejected step below the tolerance means that F is at
// its minimum to rounding.
Descent descend_damped(const RangeProblem& problem, const NonlinearOptions& options,
                       const Eigen::Vector3d& start_m) {
  Descent now{start_m, SolveStatus::iteration_limit, 0, kNaN};
  RangeEquations equations = linearise(problem, start_m);
  now.cost_m2 = equations.cost_m2;
  double damping = kFirstDamping;
  while (now.iterations < options.max_iterations) {
    Symmetric3 damped = equations.normal;
    damped.add_to_diagonal(damping * equations.normal.trace());
    const Symmetric3 adjugate = damped.adjugate();
    const Eigen::Vector3d step_m = (adjugate * equations.gradient) * (-1.0 / damped.determinant(adjugate));
    const Eigen::Vector3d trial_m = now.position_m + step_m;
    ++now.iterations;
    if (step_rule_holds(options, step_m)) {
      now.status = SolveStatus::converged;
      return now;
    }
    const RangeEquations trial = linearise(problem, trial_m);
    if (!(trial.cost_m2 <= now.cost_m2)) {
      if (!std::isfinite(now.cost_m2)) break;
      damping *= kDampingFactor;
      continue;
    }
    const bool done = objective_rule_holds(options, trial.cost_m2, now.cost_m2);
    now.position_m = trial_m;
    now.cost_m2 = trial.cost_m2;
    equations = trial;
    damping /= kDampingFactor;
    if (done) {
      now.status = SolveStatus::converged;
      return now;
    }
  }
  if (!std::isfinite(now.cost_m2)) now.status = SolveStatus::diverged;
  return now;
}

Descent solve_undamped(const RangeProblem& problem, const NonlinearOptions& options, const SensorPlane& plane,
                       const Eigen::Vector3d& wanted_m) {
  const Eigen::Vector3d start_m = wanted_m.allFinite() ? wanted_m : safe_start(problem, plane, wanted_m);
  const Descent descent = descend_undamped(problem, options, start_m);
  if (!plane.exact) return descent;
  return choose_minimum(problem, descent, mirrored(plane, descent), options.same_residual_m);
}

}  // namespace

Eigen::Vector3d wanted_start_m(const RangeProblem& problem, Start start, const Eigen::Vector3d& start_point_m,
                               const LinearOptions& linear) {
  if (start == Start::point) return start_point_m;
  if (start == Start::hint && problem.hint_m) return *problem.hint_m;
  const PointEstimate estimate = solve_linear(problem, linear);
  if (is_usable(estimate.status)) return estimate.position_m;
  return problem.hint_m.value_or(Eigen::Vector3d::Constant(kNaN));
}

PointEstimate solve_nonlinear(const RangeProblem& problem, const NonlinearOptions& options) {
  TRILAT_CHECK(options.damping == Damping::none || options.gradient == Gradient::corrected,
               "only the corrected gradient can be damped");
  const SolveStatus refusal = refusal_of(problem);
  if (refusal != SolveStatus::not_solved) return failed_estimate(refusal);
  if (options.start == Start::point && !options.start_point_m.allFinite())
    return failed_estimate(SolveStatus::non_finite_input);
  const SensorPlane plane = plane_of(problem);
  if (plane.collinear) return failed_estimate(SolveStatus::rank_deficient);
  const Eigen::Vector3d wanted_m =
      wanted_start_m(problem, options.start, options.start_point_m, options.linear);
  if (options.damping == Damping::none)
    return estimate_of(problem, solve_undamped(problem, options, plane, wanted_m));
  const auto descend = [&](const Eigen::Vector3d& start_m) {
    return descend_damped(problem, options, start_m);
  };
  return estimate_of(problem, descend_on_both_sides(problem, plane, safe_start(problem, plane, wanted_m),
                                                    options.same_residual_m, descend));
}

}  // namespace trilat
