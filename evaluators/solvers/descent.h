// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

#include <Eigen/Core>

#include "evaluators/solvers/point_estimate.h"
#include "evaluators/solvers/range_problem.h"
#include "evaluators/solvers/symmetric3.h"

namespace trilat {

enum class Gradient : std::uint8_t {
  // eq. 17 as printed, erratum E7: the step shrinks by about unit / distance, and unless the distances are
  // equal it ends where sum(u f / d) = 0, which is not the minimum of F.
  printed,
  corrected,  // J^T f
};

enum class Damping : std::uint8_t {
  none,  // eq. 14: the plain step, one descent from the start
  lm,    // Levenberg and Marquardt, on both sides of the sensors' plane; corrected gradient only
};

enum class StopRule : std::uint8_t {
  printed,    // eq. 19, erratum E8: F_k - F_{k-1} < threshold, true as soon as F falls
  objective,  // |F_k - F_{k-1}| < threshold
  step,       // |x_k - x_{k-1}| < step_tolerance
};

// What the step inverts.
enum class Curvature : std::uint8_t {
  gauss_newton,  // J^T J (eq. 14, which the paper calls Newton iteration: erratum E10)
  // Half the Hessian of F, J^T J + sum (1 - r/d) (I - u u^T), once Gauss-Newton predicts F well.
  newton,
};

struct DescentOptions {
  Gradient gradient = Gradient::corrected;
  Damping damping = Damping::lm;
  StopRule stop = StopRule::step;
  Curvature curvature = Curvature::gauss_newton;
  double threshold_m2 = 1e-8;       // of printed and objective; the paper's C is in cm^2
  double step_tolerance_m = 1e-10;  // of step
  int max_iterations = 1000;
  // The length in which the printed gradient counts distances. The paper's figures are in centimetres; in
  // metres its step would be 100 times as long.
  double printed_unit_m = 0.01;
};

// What is wrong with these options together, as a sentence; empty when nothing is.
std::string contradiction_in(const DescentOptions& options);

// Nearer than this to a sensor the direction to it is rounding: its row of J shrinks to zero.
inline constexpr double kOnSensor_m = 1e-12;

// F = sum f^2, f = |x - s| - r (eq. 10), and its linearisation at x: rows of J are the unit vectors u from
// the sensors.
struct RangeEquations {
  Symmetric3 matrix;         // what the step inverts
  Eigen::Vector3d gradient;  // J^T f, half the derivative of F; or what eq. 17 prints in its place
  double cost_m2 = 0.0;      // F
  double grain_m2 = 0.0;     // sum of |f| d: F's rounding error is some 1e-16 of it
};

// By the options' gradient; `curvature` says whether to use the whole Hessian.
RangeEquations linearise(const RangeProblem& problem, const Eigen::Vector3d& x_m,
                         const DescentOptions& options, Curvature curvature);
// J^T J, J^T f and F.
RangeEquations linearise(const RangeProblem& problem, const Eigen::Vector3d& x_m);

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

// Where one descent from one start has ended.
struct Descent {
  Eigen::Vector3d position_m = Eigen::Vector3d::Constant(kNaN);
  SolveStatus status = SolveStatus::not_solved;
  int iterations = 0;  // steps tried
  double cost_m2 = kNaN;
};

// Minimises F from a start. Ends with
//   converged        the stop rule held
//   rank_deficient   is_rank_deficient() of J^T J at an iterate (without damping only)
//   iteration_limit  max_iterations steps were tried
//   diverged         F at an iterate is not finite
// With damping F never rises by more than rounding. InternalError when contradiction_in(options).
[[nodiscard]] Descent descend(const RangeProblem& problem, const Eigen::Vector3d& start_m,
                              const DescentOptions& options);

// The estimate at x with cost, gdop (infinite where the directions do not span space) and covariance, the
// Cramer-Rao bound (J^T J)^-1 of ranges with variance 1 (NaN where gdop is infinite).
[[nodiscard]] PointEstimate estimate_at(const RangeProblem& problem, const Eigen::Vector3d& x_m,
                                        SolveStatus status, int iterations);

// The end of a descent with its geometry; rank_deficient when the directions do not span space there.
[[nodiscard]] PointEstimate estimate_of(const RangeProblem& problem, const Descent& descent);

}  // namespace trilat
