// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>

#include "evaluators/solvers/range_problem.h"

namespace trilat {

// Linear trilateration of a rig that does not move: its equations hold the squared ranges on the right side
// only, so the least-squares answer is x = offset + factor * r^2.
struct LinearStart {
  std::array<double, 3> offset_m{};
  std::array<std::array<double, kMaxSensors>, 3> factor_per_m{};

  // Columns of `range_m` (a row a sensor) to columns of `position_m` (3 rows).
  void positions(int sensors, std::size_t count, std::size_t stride, const double* range_m,
                 double* position_m) const;
};

// The sensors of `problem`, the first of which is the reference, as in solve_linear() by default. They must
// be four or more and not in one plane.
LinearStart linear_start(const RangeProblem& problem);

}  // namespace trilat
