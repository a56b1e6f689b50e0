// SPDX-License-Identifier: MIT
#include "evaluators/solvers/range_equations.h"

#include <cmath>
#include <limits>

namespace trilat {
namespace {

// `printed_unit_m` is read only by the printed gradient.
template <bool printed>
RangeEquations equations_at(const RangeProblem& problem, const Eigen::Vector3d& x_m, double printed_unit_m) {
  RangeEquations result{{}, Eigen::Vector3d::Zero(), 0.0};
  for (int i = 0; i < problem.count; ++i) {
    const Eigen::Vector3d from_sensor = x_m - problem.sensor_m[i];
    const double distance = std::sqrt(from_sensor.x() * from_sensor.x() + from_sensor.y() * from_sensor.y() +
                                      from_sensor.z() * from_sensor.z());
    const double inverse = distance > kOnSensor_m ? 1.0 / distance : 0.0;
    const Eigen::Vector3d unit = from_sensor * inverse;
    const double f = distance - problem.range_m[i];
    const double wf = problem.weight[i] * f;
    result.normal.add_outer(problem.weight[i], unit);
    result.gradient += unit * (printed ? wf * (printed_unit_m * inverse) : wf);
    result.cost_m2 += wf * f;
  }
  return result;
}

}  // namespace

RangeEquations linearise(const RangeProblem& problem, const Eigen::Vector3d& x_m) {
  return equations_at<false>(problem, x_m, 0.0);
}

RangeEquations linearise_as_printed(const RangeProblem& problem, const Eigen::Vector3d& x_m, double unit_m) {
  return equations_at<true>(problem, x_m, unit_m);
}

bool is_rank_deficient(const Symmetric3& normal, const Symmetric3& adjugate, double determinant) {
  const double trace = normal.trace();
  const double pairs = adjugate.trace();
  // Negated, so that NaN counts as deficient.
  return !(pairs > kRankRatio * trace * trace && determinant > kRankRatio * trace * pairs);
}

PointEstimate estimate_at(const RangeProblem& problem, const Eigen::Vector3d& x_m, SolveStatus status,
                          int iterations) {
  PointEstimate result;
  result.position_m = x_m;
  result.status = status;
  result.iterations = iterations;
  Symmetric3 unweighted;
  Symmetric3 weighted;
  result.cost_m2 = 0.0;
  for (int i = 0; i < problem.count; ++i) {
    const Eigen::Vector3d from_sensor = x_m - problem.sensor_m[i];
    const double distance = from_sensor.norm();
    const Eigen::Vector3d unit =
        distance > kOnSensor_m ? from_sensor * (1.0 / distance) : Eigen::Vector3d::Zero().eval();
    const double f = distance - problem.range_m[i];
    unweighted.add_outer(1.0, unit);
    weighted.add_outer(problem.weight[i], unit);
    result.cost_m2 += problem.weight[i] * f * f;
  }
  const Symmetric3 adjugate = unweighted.adjugate();
  const double determinant = unweighted.determinant(adjugate);
  if (is_rank_deficient(unweighted, adjugate, determinant)) {
    result.gdop = std::numeric_limits<double>::infinity();
    return result;
  }
  result.gdop = std::sqrt(adjugate.trace() / determinant);
  const Symmetric3 weighted_adjugate = weighted.adjugate();
  result.covariance = weighted_adjugate.matrix() / weighted.determinant(weighted_adjugate);
  return result;
}

}  // namespace trilat
