// SPDX-License-Identifier: MIT
#include "evaluators/ceres/ceres_trilateration.h"

#include <cmath>
#include <memory>

#include <ceres/problem.h>
#include <ceres/sized_cost_function.h>
#include <ceres/solver.h>

#include "evaluators/solvers/descent.h"

namespace trilat {
namespace {

// |x - s| - r of one sensor.
class RangeResidual final : public ceres::SizedCostFunction<1, 3> {
 public:
  RangeResidual(const Eigen::Vector3d& sensor_m, double range_m) : sensor_m_(sensor_m), range_m_(range_m) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const Eigen::Vector3d from_sensor = Eigen::Map<const Eigen::Vector3d>(parameters[0]) - sensor_m_;
    const double distance = from_sensor.norm();
    residuals[0] = distance - range_m_;
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    const double factor = distance > kOnSensor_m ? 1.0 / distance : 0.0;
    Eigen::Map<Eigen::Vector3d> row(jacobians[0]);
    row = factor * from_sensor;
    return true;
  }

 private:
  Eigen::Vector3d sensor_m_;
  double range_m_;
  double scale_;
};

ceres::Solver::Options solver_options(const CeresOptions& options) {
  ceres::Solver::Options result;
  result.linear_solver_type = ceres::DENSE_QR;
  result.logging_type = ceres::SILENT;
  result.num_threads = 1;
  result.function_tolerance = options.function_tolerance;
  result.gradient_tolerance = options.gradient_tolerance;
  result.parameter_tolerance = options.parameter_tolerance;
  result.max_num_iterations = options.max_iterations;
  // Damping by a multiple of the identity, as in descent.cpp. The default scales it by the diagonal of J^T
  // J, which vanishes across the sensors' plane, where it is needed most.
  result.jacobi_scaling = false;
  result.min_lm_diagonal = 1.0;
  result.max_lm_diagonal = 1.0;
  return result;
}

}  // namespace

Descent descend_by_ceres(const RangeProblem& problem, const CeresOptions& options,
                         const Eigen::Vector3d& start_m) {
  const double start_cost_m2 = linearise(problem, start_m).cost;
  if (!std::isfinite(start_cost_m2)) return {start_m, SolveStatus::diverged, 0, start_cost_m2};
  Eigen::Vector3d x = start_m;
  ceres::Problem least_squares;
  for (int i = 0; i < problem.count; ++i) {
    auto residual = std::make_unique<RangeResidual>(problem.sensor_m[i], problem.range_m[i]);
    least_squares.AddResidualBlock(residual.release(), nullptr, x.data());
  }
  ceres::Solver::Summary summary;
  ceres::Solve(solver_options(options), &least_squares, &summary);
  Descent result{x, SolveStatus::diverged, 0, 2.0 * summary.final_cost};
  result.iterations = summary.num_successful_steps + summary.num_unsuccessful_steps;
  if (summary.termination_type == ceres::CONVERGENCE) result.status = SolveStatus::converged;
  if (summary.termination_type == ceres::NO_CONVERGENCE) result.status = SolveStatus::iteration_limit;
  return result;
}

PointEstimate solve_ceres(const RangeProblem& problem, const CeresOptions& options) {
  const SolveStatus refusal = validate(problem);
  if (refusal != SolveStatus::not_solved) return failed_estimate(refusal);
  if (options.start == Start::point && !options.start_point_m.allFinite())
    return failed_estimate(SolveStatus::non_finite_input);
  const SensorPlane plane = plane_of(problem);
  if (plane.collinear) return failed_estimate(SolveStatus::rank_deficient);
  const Eigen::Vector3d wanted_m =
      requested_start_m(problem, plane, options.start, options.start_point_m, options.linear);
  return estimate_of(problem,
                     descend_on_both_sides(problem, plane, plausible_start(problem, plane, wanted_m),
                                           options.range_sigma_m, [&](const Eigen::Vector3d& start_m) {
                                             return descend_by_ceres(problem, options, start_m);
                                           }));
}

}  // namespace trilat
