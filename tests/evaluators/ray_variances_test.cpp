// SPDX-License-Identifier: MIT
#include "evaluators/fusion/ray_variances.h"

#include <gmock/gmock.h>

#include "tests/evaluators/ray_data.h"

namespace trilat {
namespace {

TEST(RayVariances, RatiosAreFoundFromDisagreementAlone) {
  for (const double ratio : {0.05, 0.1, 0.3, 1.0, 2.0, 5.0}) {
    const RayData data = ray_data({.ratio = ratio, .instants = 3000}, 21);
    const RaySigmaEstimate estimate = data.estimate();
    ASSERT_EQ(estimate.problem, "") << ratio;
    EXPECT_NEAR(estimate.ratio_of() / ratio, 1.0, 0.06) << ratio;
    EXPECT_NEAR(estimate.sigma.bearing_m / sigmas_of(ratio, kTotal_m).bearing_m, 1.0, 0.03) << ratio;
    EXPECT_LT(estimate.ratio.low, ratio);
    EXPECT_GT(estimate.ratio.high, ratio);
  }
}

TEST(RayVariances, WhatAllSensorsShareIsNotSeen) {
  RayDataSpec spec{.ratio = 0.5, .instants = 3000};
  const double alone = ray_data(spec, 22).estimate().ratio_of();
  spec.shared_m = kTotal_m;
  const RaySigmaEstimate shared = ray_data(spec, 22).estimate();
  EXPECT_NEAR(shared.ratio_of() / alone, 1.0, 0.02);
  EXPECT_NEAR(shared.sigma.range_m / sigmas_of(0.5, kTotal_m).range_m, 1.0, 0.03);
}

TEST(RayVariances, IntervalsCoverAlsoWhenErrorsAreCorrelatedInTime) {
  const Coverage coverage = coverage_of_intervals({.ratio = 0.8, .instants = 600, .correlation = 0.8}, 40);
  EXPECT_EQ(coverage.estimated, 40u);
  EXPECT_GT(coverage.ratio, 0.87);
  EXPECT_GT(coverage.range, 0.87);
  EXPECT_GT(coverage.bearing, 0.87);
}

TEST(RayVariances, TwoSensorsAtRightAnglesAreEnoughAndOneIsNot) {
  const RaySigmaEstimate two =
      ray_data({.ratio = 0.5, .instants = 3000, .rig = circle_rig({1.0, 1.4}, 2.0, 180.0)}, 23).estimate();
  ASSERT_EQ(two.problem, "");
  EXPECT_NEAR(two.ratio_of(), 0.5, 0.05);
  const RaySigmaEstimate one = ray_data({.instants = 300, .rig = circle_rig({1.0})}, 24).estimate();
  EXPECT_THAT(one.problem, testing::HasSubstr("two sensors"));
}

TEST(RayVariances, TheFactorOfInferredJointsIsFoundWithTheSigmas) {
  for (const double factor : {1.0, 3.0})
    for (const double ratio : {0.3, 2.0}) {
      const RaySigmaEstimate estimate =
          ray_data({.ratio = ratio, .inferred_share = 0.2, .inferred_factor = factor}, 1).estimate();
      EXPECT_NEAR(estimate.sigma.inferred_factor, factor, 0.05 * factor);
      EXPECT_NEAR(estimate.ratio_of(), ratio, 0.04 * ratio);
    }
  const Coverage coverage = coverage_of_intervals(
      {.ratio = 0.5, .instants = 600, .inferred_share = 0.2, .inferred_factor = 2.0}, 40);
  EXPECT_EQ(coverage.estimated, 40u);
  EXPECT_GE(coverage.ratio, 0.87);
}

TEST(RayVariances, InferredJointsAndTooFewStretchesSayNothing) {
  RayData data = ray_data({.instants = 100}, 25);
  for (std::uint32_t& cluster : data.cluster) cluster %= 4;
  EXPECT_THAT(data.estimate().problem, testing::HasSubstr("fewer than 5 stretches"));
  for (JointObservation& o : data.observations) o.state = TrackingState::inferred;
  EXPECT_FALSE(data.estimate().problem.empty());
}

}  // namespace
}  // namespace trilat
