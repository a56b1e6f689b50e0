// SPDX-License-Identifier: MIT
#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "datasets/base/philox.h"
#include "evaluators/fusion/baselines.h"

namespace trilat {
namespace {

using Eigen::Vector3d;

JointObservation at(const Vector3d& point, TrackingState state = TrackingState::tracked,
                    double range_m = 2.0) {
  return {true, state, point, range_m};
}

Vector3d normal_vector(const RandomStream& random) {
  return {random.normal(0), random.normal(1), random.normal(2)};
}

double sum_of_distances(const std::vector<JointObservation>& observations, const Vector3d& x) {
  double sum = 0.0;
  for (const JointObservation& o : observations) sum += (o.point_in_world_m - x).norm();
  return sum;
}

TEST(Median, LeavesNoNeighbourWithAShorterSum) {
  for (std::uint64_t trial = 0; trial < 300; ++trial) {
    std::vector<JointObservation> seen;
    const std::size_t count = 3 + trial % 6;
    for (std::size_t i = 0; i < count; ++i)
      seen.push_back(at(normal_vector({7, Purpose::test, trial * 16 + i})));
    const PointEstimate estimate = solve_median(seen, {});
    ASSERT_TRUE(is_usable(estimate.status)) << trial;
    const double least = sum_of_distances(seen, estimate.position_m);
    for (const double step_m : {1e-2, 1e-4})
      for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {-1.0, 1.0}) {
          const Vector3d neighbour = estimate.position_m + sign * step_m * Vector3d::Unit(axis);
          EXPECT_LE(least, sum_of_distances(seen, neighbour) + 1e-12) << trial;
        }
  }
}

// Beside two points that nearly coincide, Newton's steps are far too long.
TEST(Median, ConvergesBesidePointsThatNearlyCoincide) {
  for (std::uint64_t trial = 0; trial < 300; ++trial) {
    std::vector<JointObservation> seen;
    for (std::size_t i = 0; i < 4; ++i)
      seen.push_back(at(normal_vector({11, Purpose::test, trial * 16 + i})));
    const double apart_m = std::pow(10.0, -4.0 - 4.0 * static_cast<double>(trial) / 300.0);
    seen[1].point_in_world_m =
        seen[0].point_in_world_m + apart_m * normal_vector({11, Purpose::test, trial * 16 + 5});
    const PointEstimate estimate = solve_median(seen, {});
    EXPECT_NE(estimate.status, SolveStatus::iteration_limit) << trial;
    const double least_m = sum_of_distances(seen, estimate.position_m);
    for (int axis = 0; axis < 3; ++axis)
      for (const double step_m : {-1e-5, 1e-5, -1e-3, 1e-3})
        EXPECT_LE(least_m,
                  sum_of_distances(seen, estimate.position_m + step_m * Vector3d::Unit(axis)) + 1e-12)
            << trial;
  }
}

TEST(Median, StandsOnAPointThatOutweighsTheOthers) {
  const std::vector<JointObservation> seen{at({0, 0, 0}), at({1, 0, 0}), at({0, 1, 0}), at({-1, 0, 0}),
                                           at({0, -1, 0})};
  EXPECT_NEAR(solve_median(seen, {}).position_m.norm(), 0.0, 1e-9);
}

TEST(Median, OfTwoIsTheirMiddleAndOfOneItself) {
  EXPECT_EQ(solve_median(std::vector{at({0, 0, 0}), at({2, 0, 0})}, {}).position_m, Vector3d(1, 0, 0));
  EXPECT_EQ(solve_median(std::vector{at({3, 4, 5})}, {}).position_m, Vector3d(3, 4, 5));
}

TEST(Median, OneWrongSensorMovesTheMeanFarAndItLittle) {
  std::vector<JointObservation> seen{at({0, 0, 0}), at({0.02, 0, 0}), at({-0.02, 0.01, 0}), at({0, 0, 0.6})};
  EXPECT_NEAR(solve_mean(seen, {}).position_m.z(), 0.15, 1e-12);
  EXPECT_LT(solve_median(seen, {}).position_m.norm(), 0.02);
}

TEST(Mean, LeavesOutTheOneFarthestFromTheMedianBeyondALimit) {
  const std::vector<JointObservation> seen{at({0, 0, 0}), at({0.03, 0, 0}), at({0, 0, 0.2}),
                                           at({0, 0.17, 0})};
  EXPECT_NEAR(solve_mean(seen, {.outlier_m = 0.15}).position_m.z(), 0.0, 1e-12);  // one alone
  EXPECT_NEAR(solve_mean(seen, {.outlier_m = 0.15}).position_m.y(), 0.17 / 3, 1e-12);
  EXPECT_EQ(solve_mean(seen, {.outlier_m = 0.3}).position_m, solve_mean(seen, {}).position_m);
  EXPECT_EQ(solve_mean({}, {.outlier_m = 0.15}).status, SolveStatus::no_observation);
}

TEST(Mean, WhatIsNotSeenOrNotAllowedIsNoOutlier) {
  std::vector<JointObservation> seen{at({0, 0, 0}), at({0.03, 0, 0}), at({0, 0, 0.2}), at({0, 0, 9.0}),
                                     at({0, 9.0, 0})};
  seen[3].seen = false;
  const double z_m = solve_mean(seen, {.allowed = 0b01111, .outlier_m = 0.15}).position_m.z();
  EXPECT_NEAR(z_m, 0.0, 1e-12);  // the third alone is left out
}

TEST(Median, AllowsOnlyTheSensorsOfTheMask) {
  const std::vector<JointObservation> seen{at({0, 0, 0}), at({1, 0, 0}), at({2, 0, 0})};
  EXPECT_EQ(solve_median(seen, {.allowed = SensorMask(0b110)}).position_m, Vector3d(1.5, 0, 0));
  EXPECT_EQ(solve_median(seen, {.allowed = SensorMask(0b000)}).status, SolveStatus::no_observation);
}

TEST(Median, APointThatIsNotFiniteIsSaid) {
  const std::vector<JointObservation> seen{at({0, 0, 0}), at({kNaN, 0, 0}), at({1, 0, 0})};
  EXPECT_EQ(solve_median(seen, {}).status, SolveStatus::non_finite_input);
}

}  // namespace
}  // namespace trilat
