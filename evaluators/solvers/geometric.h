// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "evaluators/solvers/point_estimate.h"
#include "evaluators/solvers/range_problem.h"

namespace trilat {

struct GeometricOptions {
  // The rig's numbers of the three sensors; too_few_ranges when one of them does not see the joint.
  std::array<int, 3> sensors{0, 1, 2};
};

// Common points of three spheres. Of the two mirror solutions the guess chooses as in choose_mirror();
// without a decision the status is mirror_ambiguous. With h the height above the sensors' plane:
//   h^2 < -1e-10 r^2   the spheres do not meet: the nearest point of the plane, clamped
//   h^2 <= 1e-10 r^2   the joint is in the plane and h is rounding: rank_deficient
// and rank_deficient too when the three are within 1e-6 of their distance of one line. Cost, gdop and
// covariance are those of the three.
[[nodiscard]] PointEstimate solve_geometric(const RangeProblem& problem, const GeometricOptions& options);

}  // namespace trilat
