// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

#include <Eigen/Core>

#include "evaluators/solvers/descent_options.h"
#include "evaluators/solvers/point_estimate.h"
#include "evaluators/solvers/symmetric3.h"

namespace trilat {

// A sum of squares F at a place x, half its derivative, and what a step inverts.
struct Linearised {
  Symmetric3 matrix;            // J^T J, or half the Hessian of F
  Eigen::Vector3d gradient;     // J^T f
  double cost = 0.0;            // F
  double rounding_scale = 0.0;  // sum of |f| d: F's rounding error is some 1e-16 of it
};

// End of one descent from one start.
struct Descent {
  Eigen::Vector3d position_m = Eigen::Vector3d::Constant(kNaN);
  SolveStatus status = SolveStatus::not_solved;
  int iterations = 0;  // steps tried
  double cost = kNaN;  // F
};

// Sums go by x, y, z, as in range_lanes.cpp.
inline double dot(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return a.x() * b.x() + a.y() * b.y() + a.z() * b.z();
}

inline bool objective_rule_holds(const DescentOptions& options, double change) {
  if (options.stop == StopRule::printed) return change < options.threshold_m2;  // erratum E8
  return options.stop == StopRule::objective && std::abs(change) < options.threshold_m2;
}

inline bool step_rule_holds(const DescentOptions& options, const Eigen::Vector3d& step_m) {
  return options.stop == StopRule::step &&
         dot(step_m, step_m) < options.step_tolerance_m * options.step_tolerance_m;
}

// The step that solves matrix * step = -gradient, by the adjugate inverse of eq. 18.
inline Eigen::Vector3d step_of(const Symmetric3& adjugate, double determinant,
                               const Eigen::Vector3d& gradient) {
  return (adjugate * gradient) * (-1.0 / determinant);
}

// The factor on the damping after a step that lowered F by `gained` of the `predicted`: it falls fast while
// the linearisation predicts F well and stays while it just does.
inline double damping_factor(double gained, double predicted) {
  if (std::abs(gained - predicted) < 0.1 * predicted) return 0.05;
  if (gained > 0.75 * predicted) return 1.0 / 3.0;
  return gained > 0.25 * predicted ? 1.0 : 2.0;
}

// Levenberg and Marquardt's descent of any F from a start: (J^T J + lambda I) step = -J^T f. A step that
// raises F, or a matrix that is not positive definite, is taken back and tried again with more damping: F
// never rises by more than rounding. Ends with converged, iteration_limit or diverged, by the stop rule and
// the most iterations of the options. `linearise(x, curvature)` gives a Linearised, `scale` the length of J^T
// J that damping is a share of.
template <class Linearise>
Descent minimise(const Linearise& linearise, const Eigen::Vector3d& start_m, double scale,
                 const DescentOptions& options) {
  constexpr double kRounding = 4e-15;  // of rounding_scale: a smaller change of F is rounding
  // Damping below which newton uses the whole Hessian: Gauss-Newton has then predicted F well. Farther off
  // the Hessian is indefinite, and its steps may leave for another minimum.
  constexpr double kHessianBelow = 2e-5;
  Curvature curvature = Curvature::gauss_newton;
  Linearised here = linearise(start_m, curvature);
  Descent now{start_m, SolveStatus::iteration_limit, 0, here.cost};
  if (!std::isfinite(here.cost)) now.status = SolveStatus::diverged;
  double damping = 1e-4, growth = 2.0;
  while (now.status == SolveStatus::iteration_limit && now.iterations < options.max_iterations) {
    ++now.iterations;
    const double lambda = damping * scale;
    Symmetric3 damped = here.matrix;
    damped.add_to_diagonal(lambda);
    const Symmetric3 adjugate = damped.adjugate();
    const double determinant = damped.determinant(adjugate);
    const bool is_positive = damped.xx > 0.0 && adjugate.zz > 0.0 && determinant > 0.0;
    const Eigen::Vector3d step_m = step_of(adjugate, determinant, here.gradient);
    const Eigen::Vector3d there_m = now.position_m + step_m;
    if (is_positive && step_rule_holds(options, step_m)) {  // the last step is taken unseen
      now.position_m = there_m;
      now.status = SolveStatus::converged;
      break;
    }
    const Linearised there = linearise(there_m, curvature);
    double gained = here.cost - there.cost;
    double predicted = lambda * dot(step_m, step_m) - dot(step_m, here.gradient);
    // Also where the step is not taken: at the minimum itself none is.
    if (is_positive && objective_rule_holds(options, -gained)) now.status = SolveStatus::converged;
    // Near the minimum F says nothing any more, and the gradient takes its place.
    if (std::abs(gained) <= kRounding * here.rounding_scale) {
      predicted = dot(here.gradient, here.gradient);
      gained = predicted - dot(there.gradient, there.gradient);
    }
    const bool is_taken = is_positive && gained > 0.0;
    damping *= is_taken ? damping_factor(gained, predicted) : growth;
    growth = is_taken ? 2.0 : 2.0 * growth;
    if (options.curvature == Curvature::newton)
      curvature = damping < kHessianBelow ? Curvature::newton : Curvature::gauss_newton;
    if (!is_taken) continue;
    now.position_m = there_m;
    now.cost = there.cost;
    here = there;
  }
  return now;
}

}  // namespace trilat
