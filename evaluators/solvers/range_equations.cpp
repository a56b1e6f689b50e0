// SPDX-License-Identifier: MIT
#include "evaluators/solvers/range_equations.h"

#include <cmath>
#include <limits>

namespace trilat {
namespace {

// `printed_unit_m` is read only by the printed gradient.
template <bool printed>
RangeEquations equations_at(const PackedRanges& ranges, const Eigen::Vector3d& x_m,
                            double printed_unit_m) {
  using Eigen::Array2d;
  Array2d xx = Array2d::Zero(), xy = xx, xz = xx, yy = xx, yz = xx, zz = xx;
  Array2d gx = xx, gy = xx, gz = xx, cost = xx;
  for (int p = 0; p < ranges.pairs; ++p) {
    Array2d ux = x_m.x() - ranges.x_m[p];
    Array2d uy = x_m.y() - ranges.y_m[p];
    Array2d uz = x_m.z() - ranges.z_m[p];
    const Array2d distance = (ux * ux + uy * uy + uz * uz).sqrt();
    const Array2d inverse = 1.0 / distance.max(kOnSensor_m);
    ux *= inverse;
    uy *= inverse;
    uz *= inverse;
    const Array2d f = distance - ranges.range_m[p];
    const Array2d wf = ranges.weight[p] * f;
    cost += wf * f;
    const Array2d right = printed ? (wf * (printed_unit_m * inverse)).eval() : wf;
    gx += ux * right;
    gy += uy * right;
    gz += uz * right;
    const Array2d wx = ranges.weight[p] * ux;
    const Array2d wy = ranges.weight[p] * uy;
    xx += wx * ux;
    xy += wx * uy;
    xz += wx * uz;
    yy += wy * uy;
    yz += wy * uz;
    zz += ranges.weight[p] * uz * uz;
  }
  return {{xx.sum(), xy.sum(), xz.sum(), yy.sum(), yz.sum(), zz.sum()},
          {gx.sum(), gy.sum(), gz.sum()},
          cost.sum()};
}

}  // namespace

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

RangeEquations linearise(const PackedRanges& ranges, const Eigen::Vector3d& x_m) {
  return equations_at<false>(ranges, x_m, 0.0);
}

RangeEquations linearise_as_printed(const PackedRanges& ranges, const Eigen::Vector3d& x_m,
                                    double unit_m) {
  return equations_at<true>(ranges, x_m, unit_m);
}

bool is_rank_deficient(const Symmetric3& normal, const Symmetric3& adjugate, double determinant) {
  const double trace = normal.trace();
  const double pairs = adjugate.trace();
  // Negated, so that NaN counts as deficient.
  return !(pairs > kRankRatio * trace * trace && determinant > kRankRatio * trace * pairs);
}

PointEstimate estimate_at(const RangeProblem& problem, const Eigen::Vector3d& x_m,
                          SolveStatus status, int iterations) {
  PointEstimate result;
  result.position_m = x_m;
  result.status = status;
  result.iterations = iterations;
  PackedRanges ranges = packed(problem);
  const RangeEquations equations = linearise(ranges, x_m);
  result.cost_m2 = equations.cost_m2;
  for (int i = 0; i < problem.count; ++i) ranges.weight[i / 2][i % 2] = 1.0;
  const Symmetric3 unweighted = linearise(ranges, x_m).normal;
  const Symmetric3 adjugate = unweighted.adjugate();
  const double determinant = unweighted.determinant(adjugate);
  if (is_rank_deficient(unweighted, adjugate, determinant)) {
    result.gdop = std::numeric_limits<double>::infinity();
    return result;
  }
  result.gdop = std::sqrt(adjugate.trace() / determinant);
  const Symmetric3 inverse = equations.normal.adjugate();
  result.covariance = inverse.matrix() / equations.normal.determinant(inverse);
  return result;
}

}  // namespace trilat
