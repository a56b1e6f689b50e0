// SPDX-License-Identifier: MIT
#include "evaluators/solvers/nonlinear.h"

#include <algorithm>
#include <cmath>

#include "datasets/base/check.h"
#include "evaluators/solvers/both_sides.h"
#include "evaluators/solvers/range_equations.h"

namespace trilat {
namespace {

constexpr double kFirstDamping = 1e-4;
constexpr double kGoodPrediction = 0.1;
constexpr double kFastDecay = 0.05;

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
template <bool printed>
Descent descend_undamped(const PackedRanges& ranges, const NonlinearOptions& options,
                         const Eigen::Vector3d& start_m) {
  Descent now{start_m, SolveStatus::iteration_limit, 0, kNaN};
  RangeEquations equations = linearise<printed>(ranges, start_m, options.printed_unit_m);
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
    equations = linearise<printed>(ranges, now.position_m, options.printed_unit_m);
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

// Damping as a share of the sum of weights, which is the trace of J^T W J. It falls fast while the
// linearisation predicts the cost well, settles where it just does, and grows faster and faster
// while steps are taken back (after Nielsen 1999).
struct LmDamping {
  double share = kFirstDamping;
  double growth = 2.0;

  void step_taken(double gain_ratio) {
    const double miss = 2.0 * gain_ratio - 1.0;
    const double factor = 1.0 - miss * miss * miss;
    share *= std::abs(gain_ratio - 1.0) < kGoodPrediction ? kFastDecay : std::max(1.0 / 3.0, factor);
    growth = 2.0;
  }
  void step_taken_back() {
    share *= growth;
    growth *= 2.0;
  }
};

// (J^T W J + lambda I) step = -J^T W f. A step that raises F is taken back and tried again with
// more damping, so F never rises, and steps below the tolerance that still raise it mean that F is
// at its minimum to rounding.
Descent descend_damped(const PackedRanges& ranges, const NonlinearOptions& options,
                       const Eigen::Vector3d& start_m) {
  RangeEquations equations = linearise(ranges, start_m);
  Descent now{start_m, SolveStatus::iteration_limit, 0, equations.cost_m2};
  if (!std::isfinite(now.cost_m2)) now.status = SolveStatus::diverged;
  LmDamping damping;
  bool done = !std::isfinite(now.cost_m2);
  while (!done && now.iterations < options.max_iterations) {
    Symmetric3 damped = equations.normal;
    const double lambda = damping.share * damped.trace();
    damped.add_to_diagonal(lambda);
    const Symmetric3 adjugate = damped.adjugate();
    const Eigen::Vector3d step_m = (adjugate * equations.gradient) * (-1.0 / damped.determinant(adjugate));
    ++now.iterations;
    if (step_rule_holds(options, step_m)) {
      now.status = SolveStatus::converged;
      return now;
    }
    const RangeEquations trial = linearise(ranges, now.position_m + step_m);
    if (trial.cost_m2 <= now.cost_m2) {
      done = objective_rule_holds(options, trial.cost_m2, now.cost_m2);
      const double predicted_m2 = lambda * step_m.squaredNorm() - step_m.dot(equations.gradient);
      damping.step_taken((now.cost_m2 - trial.cost_m2) / predicted_m2);
      now.position_m += step_m;
      now.cost_m2 = trial.cost_m2;
      equations = trial;
    } else {
      damping.step_taken_back();
    }
    if (done) now.status = SolveStatus::converged;
  }
  return now;
}

Descent solve_undamped(const RangeProblem& problem, const NonlinearOptions& options, const SensorPlane& plane,
                       const Eigen::Vector3d& wanted_m) {
  const Eigen::Vector3d start_m = wanted_m.allFinite() ? wanted_m : safe_start(problem, plane, wanted_m);
  const PackedRanges ranges = packed(problem);
  const Descent descent = options.gradient == Gradient::printed
                              ? descend_undamped<true>(ranges, options, start_m)
                              : descend_undamped<false>(ranges, options, start_m);
  if (!plane.exact) return descent;
  return choose_minimum(problem, descent, mirrored(plane, descent), options.same_residual_m);
}

}  // namespace

Eigen::Vector3d wanted_start_m(const RangeProblem& problem, Start start, const Eigen::Vector3d& start_point_m,
                               const LinearOptions& linear) {
  if (start == Start::point) return start_point_m;
  if (start == Start::hint && problem.hint_m) return *problem.hint_m;
  if (const auto x_m = linear_position_m(problem, linear)) return *x_m;
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
  const PackedRanges ranges = packed(problem);
  const auto descend = [&](const Eigen::Vector3d& start_m) {
    return descend_damped(ranges, options, start_m);
  };
  return estimate_of(problem, descend_on_both_sides(problem, plane, safe_start(problem, plane, wanted_m),
                                                    options.same_residual_m, descend));
}

}  // namespace trilat
