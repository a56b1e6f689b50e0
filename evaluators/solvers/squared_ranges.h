// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "evaluators/solvers/range_problem.h"
#include "evaluators/solvers/sensor_plane.h"

namespace trilat {

// The exact global minimum of sum (|x - s|^2 - r^2)^2, for any number of sensors from three on and also when
// they stand in one plane (Beck, Stoica and Li, "Exact and approximate solutions of source localization
// problems", IEEE Trans. Signal Processing 56(5), 2008: a quadratic problem with one quadratic constraint,
// whose multiplier is the one root of a decreasing function). With x = centroid + axes y and multiplier mu it
// is y_j = c_j / (4 scatter_j + mu). When the sensors stand in one plane there are two, mirror images of each
// other; this is the one on the side of the plane's normal. `plane` is that of the
// problem, not collinear.
Eigen::Vector3d solve_squared_ranges(const RangeProblem& problem, const SensorPlane& plane);

}  // namespace trilat
