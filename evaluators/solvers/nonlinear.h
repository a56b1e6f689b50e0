// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "evaluators/solvers/linear.h"
#include "evaluators/solvers/point_estimate.h"
#include "evaluators/solvers/range_problem.h"

namespace trilat {

enum class Gradient : std::uint8_t {
  // eq. 17 as printed, erratum E7: the step shrinks by about unit / distance, and unless the
  // distances are equal it ends where sum(u f / d) = 0, which is not the minimum of F.
  printed,
  corrected,  // J^T W f
};

enum class Damping : std::uint8_t {
  none,  // eq. 14: plain Gauss-Newton, one descent from the start
  lm,    // Levenberg and Marquardt, on both sides of the sensors' plane; corrected gradient only
};

enum class StopRule : std::uint8_t {
  printed,    // eq. 19, erratum E8: F_k - F_{k-1} < threshold, true as soon as F falls
  objective,  // |F_k - F_{k-1}| < threshold
  step,       // |x_k - x_{k-1}| < step_tolerance
};

enum class Start : std::uint8_t {
  linear,  // solve_linear(); when that has no answer, the hint
  hint,    // the problem's hint; without one, linear
  point,   // start_point_m
};

struct NonlinearOptions {
  Gradient gradient = Gradient::corrected;
  Damping damping = Damping::lm;
  StopRule stop = StopRule::step;
  double threshold_m2 = 1e-8;       // of printed and objective; the paper's C is in cm^2
  double step_tolerance_m = 1e-10;  // of step
  int max_iterations = 1000;        // of each descent
  // The length in which the printed gradient counts distances. The paper's figures are in
  // centimetres; in metres its step would be 100 times as long.
  double printed_unit_m = 0.01;
  Start start = Start::linear;
  Eigen::Vector3d start_point_m = Eigen::Vector3d::Constant(kNaN);
  LinearOptions linear;  // of the linear start
  // Two minima whose root mean square residuals differ by less fit equally well, and only a hint
  // can decide. The default allows for rounding; the size of the range noise is stricter.
  double same_residual_m = 1e-9;
};

// Minimises F = sum w (|x - s| - r)^2 (eq. 10) by Gauss-Newton. Starts that are missing, and with
// lm also those that are implausible, are replaced as in safe_start(). Two solutions are told apart
// as in choose_minimum(): with lm always; without damping only when the sensors are in one plane,
// where the mirror image is a solution too. Ends with
//   converged        the stop rule held
//   rank_deficient   sensors on one line; or is_rank_deficient() at the end or, without damping, at
//                    any iterate: a joint in the plane of the sensors is such a case
//   mirror_ambiguous, iteration_limit, diverged, or a refusal of the problem.
// InternalError when lm is asked to follow the printed gradient, which is not one of F.
[[nodiscard]] PointEstimate solve_nonlinear(const RangeProblem& problem, const NonlinearOptions& options);

// Where the options want to start; NaN when there is no such point.
Eigen::Vector3d wanted_start_m(const RangeProblem& problem, Start start, const Eigen::Vector3d& start_point_m,
                               const LinearOptions& linear);

}  // namespace trilat
