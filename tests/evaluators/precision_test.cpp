// SPDX-License-Identifier: MIT
#include <numbers>
#include <vector>

#include <gmock/gmock.h>

#include "evaluators/solvers/descent.h"
#include "evaluators/solvers/nonlinear.h"
#include "tests/evaluators/range_problems.h"

namespace trilat {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// n sensors around the joint, which sees them all under one angle of elevation.
RangeProblem ring_of(int n, double elevation_rad, const Vector3d& joint_m) {
  std::vector<Vector3d> sensors_m;
  for (int k = 0; k < n; ++k) {
    const double azimuth_rad = 2.0 * std::numbers::pi * k / n + 0.3;
    const Vector3d u(std::cos(elevation_rad) * std::cos(azimuth_rad), std::sin(elevation_rad),
                     std::cos(elevation_rad) * std::sin(azimuth_rad));
    sensors_m.push_back(joint_m + (1.0 + 0.5 * k) * u);
  }
  return problem_of(sensors_m, joint_m);
}

// Sensors and joint of a rig that fixes a joint well.
RangeProblem well_posed_problem(int n, const Vector3d& joint_m) {
  std::vector<Vector3d> sensors_m;
  for (int k = 0; k < n; ++k) {
    const double azimuth_rad = 2.0 * std::numbers::pi * k / n;
    sensors_m.push_back({2.0 * std::cos(azimuth_rad), k % 2 == 0 ? 0.3 : 2.3, 2.0 * std::sin(azimuth_rad)});
  }
  return problem_of(sensors_m, joint_m);
}

// GDOP and Cramer-Rao bound at x, of ranges with variance 1.
PointEstimate precision_at(const RangeProblem& problem, const Vector3d& x_m) {
  return estimate_at(problem, x_m, SolveStatus::closed_form, 0);
}

TEST(Precision, OfDirectionsAlongTheAxesIsThatOfEachRange) {
  const RangeProblem problem = problem_of({{2, 0, 0}, {0, 3, 0}, {0, 0, 1}}, {0, 0, 0});
  const PointEstimate precision = precision_at(problem, {0, 0, 0});
  EXPECT_NEAR(precision.gdop, std::sqrt(3.0), 1e-12);
  EXPECT_LT((precision.covariance - Matrix3d::Identity()).norm(), 1e-12);
}

TEST(Precision, IsNeverBelowThreeByTheRootOfTheNumberOfSensors) {
  for (int n = 3; n <= kMaxSensors; ++n) {
    const double best_rad = std::atan(std::sqrt(0.5));
    EXPECT_NEAR(precision_at(ring_of(n, best_rad, {0, 0, 0}), {0, 0, 0}).gdop, 3.0 / std::sqrt(n), 1e-12);
    for (std::uint32_t i = 0; i < 100; ++i) {
      const RangeProblem problem = well_posed_problem(n, {0, 1, 0});
      const Vector3d x_m = random_joint_m({62, Purpose::test, 0}, i);
      EXPECT_GT(precision_at(problem, x_m).gdop, 3.0 / std::sqrt(n) - 1e-12);
    }
  }
}

TEST(Precision, IsInfiniteDilutionInThePlaneOfTheSensors) {
  const RangeProblem problem = problem_of(ring_m(0.9, 0.9, 0.9, 0.9), {0.2, 0.9, -0.3});
  const PointEstimate precision = precision_at(problem, {0.2, 0.9, -0.3});
  EXPECT_TRUE(std::isinf(precision.gdop));
  EXPECT_TRUE(precision.covariance.array().isNaN().all());
}

TEST(Precision, IsThatOfTheEstimate) {
  for (std::uint32_t i = 0; i < 50; ++i) {
    const Vector3d joint_m = random_joint_m({63, Purpose::test, 0}, i);
    RangeProblem problem = well_posed_problem(3 + static_cast<int>(i % 6), joint_m);
    problem.guess_m = joint_m;
    const PointEstimate estimate = solve_nonlinear(problem, {});
    const PointEstimate precision = precision_at(problem, estimate.position_m);
    EXPECT_NEAR(estimate.gdop, precision.gdop, 1e-9 * precision.gdop);
    EXPECT_LT((estimate.covariance - precision.covariance).norm(), 1e-9 * precision.covariance.norm());
  }
}

constexpr std::uint32_t kTrials = 40'000;  // the mean square of one axis is then known to 0.7 %

// Mean squared error of solve_nonlinear() over the trace of the bound.
double error_over_bound(int n, double range_sigma_m) {
  const Vector3d joint_m(0.25, 0.9, -0.35);
  const RangeProblem nominal = well_posed_problem(n, joint_m);
  std::vector<RangeProblem> problems(kTrials, nominal);
  for (std::uint32_t trial = 0; trial < kTrials; ++trial) {
    const RandomStream random{64, Purpose::test, trial};
    for (int i = 0; i < n; ++i)
      problems[trial].range_m[i] += range_sigma_m * random.normal(static_cast<std::uint32_t>(i));
  }
  std::vector<PointEstimate> estimates(kTrials);
  solve_nonlinear(problems, {}, estimates);
  double sum_m2 = 0.0;
  for (const PointEstimate& estimate : estimates) sum_m2 += (estimate.position_m - joint_m).squaredNorm();
  const double bound_m2 = range_sigma_m * range_sigma_m * precision_at(nominal, joint_m).covariance.trace();
  return sum_m2 / kTrials / bound_m2;
}

TEST(Precision, IsReachedByTheNonlinearSolver) {
  for (int n = 4; n <= kMaxSensors; ++n) {
    const double ratio = error_over_bound(n, 0.001);
    EXPECT_GT(ratio, 0.95) << n;
    EXPECT_LT(ratio, 1.10) << n;
  }
}

}  // namespace
}  // namespace trilat
