// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>

#include "datasets/base/words.h"
#include "evaluators/solvers/descent.h"
#include "evaluators/solvers/linear.h"
#include "evaluators/solvers/point_estimate.h"
#include "evaluators/solvers/range_problem.h"
#include "evaluators/solvers/sensor_plane.h"

namespace trilat {

enum class Start : std::uint8_t {
  squared_ranges,  // solve_squared_ranges(): the global minimum of a nearby problem
  linear,          // solve_linear(); when that has no answer, squared_ranges
  guess,           // the problem's guess; without one, squared_ranges
  point,           // start_point_m
};
template <>
inline constexpr std::array words<Start>{"squared_ranges", "linear", "guess"};

// max_iterations counts for each descent.
struct NonlinearOptions : DescentOptions {
  Start start = Start::squared_ranges;
  Eigen::Vector3d start_point_m = Eigen::Vector3d::Constant(kNaN);
  LinearOptions linear;  // of the linear start
  // Standard deviation of a range, m: ranges decide the side of the sensors' plane only where
  // ranges_decide(), else the guess. 0: the lower cost wins, however little lower.
  double range_sigma_m = kUsualRangeSigma_m;
};

// Minimises F = sum (|x - s| - r)^2 (eq. 10) by Gauss-Newton or the full Hessian. With lm, starts that are
// implausible are replaced as in plausible_start(), and the descent also goes down from the mirror image of
// its start; the best wins as in choose_minimum(). Without damping there is one descent, as the paper prints
// it, and its mirror image counts only when the sensors are exactly in one plane. Ends with
//   converged        the stop rule held
//   rank_deficient   sensors on one line; or is_rank_deficient() at the end or, without damping, at
//                    any iterate: a joint in the plane of the sensors is such a case
//   mirror_ambiguous, iteration_limit, diverged, or a refusal of the problem.
// InternalError when contradiction_in(options).
[[nodiscard]] PointEstimate solve_nonlinear(const RangeProblem& problem, const NonlinearOptions& options);

// Solves many problems, with the same bits as one by one; undamped descents go by vectors. `estimates` has
// one slot a problem.
void solve_nonlinear(std::span<const RangeProblem> problems, const NonlinearOptions& options,
                     std::span<PointEstimate> estimates);

// Start that the options name. The problem must be one that validate() does not refuse, and `plane` its
// own, not collinear.
Eigen::Vector3d requested_start_m(const RangeProblem& problem, const SensorPlane& plane, Start start,
                                  const Eigen::Vector3d& start_point_m, const LinearOptions& linear);

}  // namespace trilat
