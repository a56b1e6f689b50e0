// SPDX-License-Identifier: MIT
#include <array>

#include <ceres/problem.h>
#include <ceres/sized_cost_function.h>
#include <ceres/solver.h>
#include <ceres/tiny_solver.h>

#include "tests/benchmarks/contestants.h"

namespace trilat {
namespace {

class RangeResidual final : public ceres::SizedCostFunction<1, 3> {
 public:
  RangeResidual() = default;
  RangeResidual(const Eigen::Vector3d& sensor_m, double range_m) { set(sensor_m, range_m); }
  void set(const Eigen::Vector3d& sensor_m, double range_m) {
    sensor_m_ = sensor_m;
    range_m_ = range_m;
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const Eigen::Vector3d from_sensor = Eigen::Map<const Eigen::Vector3d>(parameters[0]) - sensor_m_;
    const double distance = from_sensor.norm();
    residuals[0] = distance - range_m_;
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    Eigen::Map<Eigen::Vector3d> row(jacobians[0]);
    row = from_sensor / distance;
    return true;
  }

 private:
  Eigen::Vector3d sensor_m_ = Eigen::Vector3d::Zero();
  double range_m_ = 0.0;
};

const std::vector<std::string> kStopRules{"function", "parameter", "gradient"};

ceres::Solver::Options solver_options(Tolerance tolerance) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  options.max_num_iterations = kMostIterations;
  options.function_tolerance = tolerance.rule == 0 ? tolerance.value : 0.0;
  options.parameter_tolerance = tolerance.rule == 1 ? tolerance.value : 0.0;
  options.gradient_tolerance = tolerance.rule == 2 ? tolerance.value : 0.0;
  return options;
}

int steps_of(const ceres::Solver::Summary& summary) {
  return summary.num_successful_steps + summary.num_unsuccessful_steps;
}

struct CeresSolve {
  ceres::Solver::Options options;

  explicit CeresSolve(Tolerance tolerance) : options(solver_options(tolerance)) {}
  int operator()(const RangeProblem& problem, Eigen::Vector3d& x_m) const {
    ceres::Problem least_squares;
    for (int i = 0; i < problem.count; ++i)
      least_squares.AddResidualBlock(new RangeResidual(problem.sensor_m[i], problem.range_m[i]), nullptr,
                                     x_m.data());
    ceres::Solver::Summary summary;
    ceres::Solve(options, &least_squares, &summary);
    return steps_of(summary);
  }
};

// The problem is built once; a solve changes what its cost functions hold.
struct CeresReused {
  ceres::Solver::Options options;
  Eigen::Vector3d x;
  std::array<RangeResidual, 4> residuals;
  ceres::Problem least_squares;

  static ceres::Problem::Options borrowing() {
    ceres::Problem::Options result;
    result.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    return result;
  }
  explicit CeresReused(Tolerance tolerance) : options(solver_options(tolerance)), least_squares(borrowing()) {
    for (RangeResidual& residual : residuals) least_squares.AddResidualBlock(&residual, nullptr, x.data());
  }
  int operator()(const RangeProblem& problem, Eigen::Vector3d& x_m) {
    for (std::size_t i = 0; i < residuals.size(); ++i)
      residuals[i].set(problem.sensor_m[i], problem.range_m[i]);
    x = x_m;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &least_squares, &summary);
    x_m = x;
    return steps_of(summary);
  }
};

struct FourRanges {
  using Scalar = double;
  enum { NUM_RESIDUALS = 4, NUM_PARAMETERS = 3 };
  const RangeProblem* problem;

  bool operator()(const double* parameters, double* residuals, double* jacobian) const {
    const Eigen::Map<const Eigen::Vector3d> x(parameters);
    for (int i = 0; i < NUM_RESIDUALS; ++i) {
      const Eigen::Vector3d from_sensor = x - problem->sensor_m[i];
      const double distance = from_sensor.norm();
      residuals[i] = distance - problem->range_m[i];
      if (jacobian) Eigen::Map<Eigen::Matrix<double, 4, 3>>(jacobian).row(i) = from_sensor / distance;
    }
    return true;
  }
};

struct Tiny {
  ceres::TinySolver<FourRanges> solver;

  explicit Tiny(Tolerance tolerance) {
    solver.options.max_num_iterations = kMostIterations;
    solver.options.cost_threshold = 0.0;
    solver.options.function_tolerance = tolerance.rule == 0 ? tolerance.value : 0.0;
    solver.options.parameter_tolerance = tolerance.rule == 1 ? tolerance.value : 0.0;
    solver.options.gradient_tolerance = tolerance.rule == 2 ? tolerance.value : 0.0;
  }
  int operator()(const RangeProblem& problem, Eigen::Vector3d& x_m) {
    return solver.Solve(FourRanges{&problem}, &x_m).iterations;
  }
};

}  // namespace

std::vector<Contestant> ceres_contestants() {
  return {one_at_a_time<CeresSolve>("ceres::Solve", kStopRules),
          one_at_a_time<CeresReused>("ceres::Solve, problem reused", kStopRules),
          one_at_a_time<Tiny>("ceres::TinySolver", kStopRules)};
}

}  // namespace trilat
