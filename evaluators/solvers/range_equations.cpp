// SPDX-License-Identifier: MIT
#include "evaluators/solvers/range_equations.h"

#include <algorithm>

#include "evaluators/solvers/precision.h"

namespace trilat {

PackedRanges packed(const RangeProblem& problem) {
  PackedRanges result;
  result.pairs = (problem.count + 1) / 2;
  for (int i = 0; i < 2 * result.pairs; ++i) {
    const int from = i < problem.count ? i : 0;
    result.x_m[i / 2][i % 2] = problem.sensor_m[from].x();
    result.y_m[i / 2][i % 2] = problem.sensor_m[from].y();
    result.z_m[i / 2][i % 2] = problem.sensor_m[from].z();
    result.range_m[i / 2][i % 2] = problem.range_m[from];
    result.weight[i / 2][i % 2] = i < problem.count ? problem.weight[from] : 0.0;
  }
  return result;
}

PointEstimate estimate_at(const RangeProblem& problem, const Eigen::Vector3d& x_m, SolveStatus status,
                          int iterations) {
  PointEstimate result;
  result.position_m = x_m;
  result.status = status;
  result.iterations = iterations;
  PackedRanges ranges = packed(problem);
  const RangeEquations equations = linearise(ranges, x_m);
  result.cost_m2 = equations.cost_m2;
  Symmetric3 unweighted = equations.normal;
  if (std::any_of(problem.weight.begin(), problem.weight.begin() + problem.count,
                  [](double weight) { return weight != 1.0; })) {
    for (int i = 0; i < problem.count; ++i) ranges.weight[i / 2][i % 2] = 1.0;
    unweighted = linearise(ranges, x_m).normal;
  }
  const Precision precision = precision_of(unweighted, equations.normal);
  result.gdop = precision.gdop;
  result.covariance = precision.covariance_m2;
  return result;
}

}  // namespace trilat
