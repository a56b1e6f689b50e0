// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "evaluators/solvers/point_estimate.h"
#include "evaluators/solvers/range_problem.h"
#include "evaluators/solvers/sensor_plane.h"

namespace trilat {

// Where one descent from one start has ended: converged, iteration_limit, rank_deficient or
// diverged.
struct Descent {
  Eigen::Vector3d position_m = Eigen::Vector3d::Constant(kNaN);
  SolveStatus status = SolveStatus::not_solved;
  int iterations = 0;
  double cost_m2 = kNaN;
};

// Minima nearer than this are one.
inline constexpr double kSameMinimum_m = 1e-6;

// A start for a descent of full rank: finite and no farther from the sensors' middle than twice their
// mean range and spread, else squared_range_position_m(); and at least a tenth of the mean range off the
// plane, where the derivative across it vanishes.
Eigen::Vector3d safe_start(const RangeProblem& problem, const SensorPlane& plane,
                           const Eigen::Vector3d& wanted_m);

// Chooses between two descents. When ranges_decide(), or both ended on one side of the sensors' plane,
// the lower cost wins, else choose_mirror() decides, and without a decision the status is
// mirror_ambiguous, of the lower one. A range_sigma_m of 0 leaves to the hint only costs that are equal but
// for rounding. The iterations of both are added.
Descent choose_minimum(const RangeProblem& problem, const SensorPlane& plane, const Descent& first,
                       const Descent& second, double range_sigma_m);

// The other minimum of a problem whose sensors are exactly in one plane.
inline Descent mirrored(const SensorPlane& plane, Descent descent) {
  descent.position_m = plane.mirrored(descent.position_m);
  descent.iterations = 0;
  return descent;
}

// Descends on both sides of the sensors' plane. `descend(start_m)` returns a Descent.
template <class Descend>
Descent descend_on_both_sides(const RangeProblem& problem, const SensorPlane& plane,
                              const Eigen::Vector3d& start_m, double range_sigma_m, const Descend& descend) {
  const Descent first = descend(start_m);
  const Descent second = plane.exact ? mirrored(plane, first) : descend(plane.mirrored(start_m));
  return choose_minimum(problem, plane, first, second, range_sigma_m);
}

// The chosen minimum with its geometry; rank_deficient when the directions do not span space there.
[[nodiscard]] PointEstimate estimate_of(const RangeProblem& problem, const Descent& descent);

}  // namespace trilat
