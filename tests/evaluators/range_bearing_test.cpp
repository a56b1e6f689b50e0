// SPDX-License-Identifier: MIT
#include "evaluators/fusion/range_bearing.h"

#include <limits>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "evaluators/fusion/baselines.h"
#include "evaluators/solvers/nonlinear.h"
#include "tests/evaluators/global_minima.h"
#include "tests/evaluators/seen_joints.h"

namespace trilat {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
const std::vector<double> kHeights{0.6, 2.2, 0.9, 1.9};

struct Errors {
  double mean_m = 0.0, ranges_m = 0.0, both_m = 0.0;  // mean length
};

Errors errors_at(double ratio, int joints) {
  const auto rig = circle_rig(kHeights);
  const RaySigma sigma = sigmas_of(ratio, 0.087);
  Errors sum;
  for (int k = 0; k < joints; ++k) {
    const RandomStream random{11, Purpose::test, static_cast<std::uint64_t>(k)};
    const Eigen::Vector3d joint_m = some_joint_m(random);
    const auto seen = seen_from(rig, joint_m, sigma, random);
    sum.mean_m += (solve_mean(seen, {}).position_m - joint_m).norm() / joints;
    sum.ranges_m += (solve_nonlinear(ranges_of(seen, rig), {}).position_m - joint_m).norm() / joints;
    sum.both_m += (solve_range_bearing(seen, rig, {.sigma = sigma}).position_m - joint_m).norm() / joints;
  }
  return sum;
}

TEST(RangeBearing, IsNeverWorseThanTheBetterOfMeanAndRanges) {
  for (const double ratio : {0.1, 0.3, 0.5, 1.0, 2.0, 5.0}) {
    const Errors errors = errors_at(ratio, 2000);
    EXPECT_LT(errors.both_m, 1.01 * std::min(errors.mean_m, errors.ranges_m)) << ratio;
    RecordProperty("ratio " + std::to_string(ratio), std::to_string(errors.mean_m) + " " +
                                                         std::to_string(errors.ranges_m) + " " +
                                                         std::to_string(errors.both_m));
  }
  EXPECT_LT(errors_at(5.0, 2000).both_m, 0.6 * errors_at(5.0, 2000).mean_m);
}

TEST(RangeBearing, WithoutBearingsIsTrilateration) {
  const auto rig = circle_rig(kHeights);
  for (std::uint64_t k = 0; k < 300; ++k) {
    const RandomStream random{12, Purpose::test, k};
    const auto seen = seen_from(rig, some_joint_m(random), {0.05, 0.05}, random);
    NonlinearOptions exact;
    exact.step_tolerance_m = 1e-12;
    const PointEstimate ranges = solve_nonlinear(ranges_of(seen, rig), exact);
    const PointEstimate few =
        solve_range_bearing(seen, rig, {.sigma = {1e-6, 100.0}, .step_tolerance_m = 1e-12});
    if (!is_usable(ranges.status)) continue;
    // solve_nonlinear() goes on while its cost falls, which rounding hides from it at some nanometres
    EXPECT_LT((few.position_m - ranges.position_m).norm(), 5e-9) << k;
  }
}

TEST(RangeBearing, WithoutRangesIsTriangulation) {
  const auto rig = circle_rig(kHeights);
  for (std::uint64_t k = 0; k < 300; ++k) {
    const RandomStream random{13, Purpose::test, k};
    const auto seen = seen_from(rig, some_joint_m(random), {0.05, 0.05}, random);
    Eigen::MatrixXd rays(12, 3);
    Eigen::VectorXd right(12);
    for (int i = 0; i < 4; ++i) {
      const Eigen::Vector3d s = rig[i].translation_m, u = (seen[i].point_in_world_m - s).normalized();
      const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - u * u.transpose();
      rays.middleRows<3>(3 * i) = across;
      right.segment<3>(3 * i) = across * s;
    }
    const Eigen::Vector3d expected = rays.colPivHouseholderQr().solve(right);
    const PointEstimate few = solve_range_bearing(seen, rig, {.sigma = {1e5, 0.01}});
    EXPECT_LT((few.position_m - expected).norm(), 1e-9) << k;
  }
}

TEST(RangeBearing, WithEqualSigmasIsTheMeanToSecondOrder) {
  const auto rig = circle_rig(kHeights);
  double largest_m = 0.0;
  for (std::uint64_t k = 0; k < 300; ++k) {
    const RandomStream random{14, Purpose::test, k};
    const auto seen = seen_from(rig, some_joint_m(random), {0.03, 0.03}, random);
    const PointEstimate both = solve_range_bearing(seen, rig, {});
    largest_m = std::max(largest_m, (both.position_m - solve_mean(seen, {}).position_m).norm());
  }
  EXPECT_LT(largest_m, 3e-3);
}

TEST(RangeBearing, AttainsItsCramerRaoBound) {
  for (const double ratio : {0.2, 1.0, 5.0}) {
    const auto rig = circle_rig(kHeights);
    const RaySigma sigma = sigmas_of(ratio, 0.05);
    double squares = 0.0, bound = 0.0, mahalanobis = 0.0;
    constexpr int kJoints = 4000;
    for (std::uint64_t k = 0; k < kJoints; ++k) {
      const RandomStream random{15, Purpose::test, k};
      const Eigen::Vector3d joint_m = some_joint_m(random);
      const PointEstimate estimate =
          solve_range_bearing(seen_from(rig, joint_m, sigma, random), rig, {.sigma = sigma});
      const Eigen::Vector3d error_m = estimate.position_m - joint_m;
      squares += error_m.squaredNorm();
      bound += estimate.covariance.trace();
      mahalanobis += error_m.dot(estimate.covariance.inverse() * error_m) / kJoints;
    }
    EXPECT_NEAR(std::sqrt(squares / bound), 1.0, 0.05) << ratio;
    EXPECT_NEAR(mahalanobis, 3.0, 0.2) << ratio;
  }
}

TEST(RangeBearing, FindsTheLowestMinimum) {
  for (const Loss loss : {Loss::squares, Loss::cauchy}) {
    const GlobalCheck check = check_global_minima(30, 20, loss);
    EXPECT_EQ(check.problems, 300u);
    EXPECT_EQ(check.missed, 0u) << check.worst_m;
  }
}

TEST(RangeBearing, MovesWithTheWorld) {
  auto rig = circle_rig(kHeights);
  const RandomStream random{16, Purpose::test, 0};
  auto seen = seen_from(rig, some_joint_m(random), {0.02, 0.06}, random);
  const RangeBearingOptions options{.sigma = {0.02, 0.06}, .loss = Loss::cauchy};
  const Eigen::Vector3d before = solve_range_bearing(seen, rig, options).position_m;
  const RigidTransform motion{Eigen::Quaterniond(0.5, -0.5, 0.5, 0.5), {1.0, -2.0, 3.0}};
  for (RigidTransform& sensor : rig) sensor.translation_m = motion * sensor.translation_m;
  for (JointObservation& o : seen) o.point_in_world_m = motion * o.point_in_world_m;
  EXPECT_LT((solve_range_bearing(seen, rig, options).position_m - motion * before).norm(), 1e-9);
}

TEST(RangeBearing, OneWrongSensorCannotPullARobustEstimateFar) {
  const auto rig = circle_rig(kHeights);
  const Eigen::Vector3d joint_m(0.1, 1.0, 0.2);
  auto seen = seen_from(rig, joint_m, {1e-6, 1e-6}, {17, Purpose::test, 0});
  seen[2].point_in_world_m += Eigen::Vector3d(0.0, 1.0, 0.0);
  seen[2].range_m = (seen[2].point_in_world_m - rig[2].translation_m).norm();
  const auto error_m = [&](Loss loss) {
    return (solve_range_bearing(seen, rig, {.loss = loss}).position_m - joint_m).norm();
  };
  EXPECT_GT(error_m(Loss::squares), 0.2);
  EXPECT_LT(error_m(Loss::cauchy), 0.03);
}

// With a view dismissed, four sensors state what the other three would.
TEST(RangeBearing, AViewThatTheLossDismissesIsNotInTheCovariance) {
  const auto rig = circle_rig(kHeights);
  const RaySigma sigma{0.03, 0.03};
  auto seen = seen_from(rig, {0.1, 1.0, 0.2}, {1e-6, 1e-6}, {18, Purpose::test, 0});
  const RangeBearingOptions options{.sigma = sigma, .loss = Loss::cauchy};
  const auto stated_m = [&] { return std::sqrt(solve_range_bearing(seen, rig, options).covariance.trace()); };
  const double all_m = stated_m();
  seen[2].point_in_world_m += Eigen::Vector3d(0.0, 1.5, 0.0);
  seen[2].range_m = (seen[2].point_in_world_m - rig[2].translation_m).norm();
  const double dismissed_m = stated_m();
  seen[2] = {};
  const double without_m = stated_m();
  EXPECT_GT(without_m, 1.1 * all_m);
  EXPECT_NEAR(dismissed_m, without_m, 0.02 * without_m);
}

TEST(RangeBearing, AnInferredJointCountsForLess) {
  const auto rig = circle_rig({1.0, 1.0});
  std::vector<JointObservation> seen{{true, TrackingState::tracked, {0, 1, 0}, 2.0},
                                     {true, TrackingState::inferred, {0.1, 1, 0}, std::hypot(2.0, 0.1)}};
  EXPECT_NEAR(solve_range_bearing(seen, rig, {.sigma = {.inferred_factor = 3.0}}).position_m.x(), 0.01, 1e-3);
}

TEST(RangeBearing, SaysWhyThereIsNoAnswer) {
  const auto rig = circle_rig({1.0, 1.0});
  std::vector<JointObservation> seen(2);
  EXPECT_EQ(solve_range_bearing(seen, rig, {}).status, SolveStatus::no_observation);
  seen[0] = {true, TrackingState::tracked, {0.3, 1.2, 0.1}, 0.0};
  seen[0].range_m = (seen[0].point_in_world_m - rig[0].translation_m).norm();
  const PointEstimate alone = solve_range_bearing(seen, rig, {});
  EXPECT_EQ(alone.status, SolveStatus::converged);
  EXPECT_LT((alone.position_m - seen[0].point_in_world_m).norm(), 1e-9);
  seen[0].range_m = kNaN;
  EXPECT_EQ(solve_range_bearing(seen, rig, {}).status, SolveStatus::non_finite_input);
  for (const RaySigma sigma : {RaySigma{0.0, 1.0}, RaySigma{1.0, kInfinite}})
    EXPECT_EQ(contradiction_in(RangeBearingOptions{.sigma = sigma}),
              "both sigmas must be greater than 0 and finite");
  EXPECT_EQ(contradiction_in(RangeBearingOptions{.loss_scale = 0.0}),
            "the scale of the loss must be greater than 0");
}

}  // namespace
}  // namespace trilat
