// SPDX-License-Identifier: MIT
#include "evaluators/solvers/range_problem.h"

#include <cmath>

#include "datasets/base/error.h"

namespace trilat {

SolveStatus validate(const RangeProblem& problem) {
  TRILAT_CHECK(problem.count >= 0 && problem.count <= kMaxSensors, "a problem holds its sensors");
  bool valid = true;
  for (int i = 0; i < problem.count; ++i) {
    const double sum = problem.sensor_m[i].cwiseAbs().sum() + problem.range_m[i];
    if (!std::isfinite(sum)) return SolveStatus::non_finite_input;
    valid = valid && problem.range_m[i] >= 0.0;
  }
  if (problem.guess_m && !problem.guess_m->allFinite()) return SolveStatus::non_finite_input;
  if (!valid) return SolveStatus::invalid_input;
  return problem.count < 3 ? SolveStatus::too_few_ranges : SolveStatus::not_solved;
}

}  // namespace trilat
