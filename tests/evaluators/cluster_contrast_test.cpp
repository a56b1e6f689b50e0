// SPDX-License-Identifier: MIT
#include <cmath>

#include <gtest/gtest.h>

#include "evaluators/metrics/statistics.h"

namespace trilat {
namespace {

TEST(ClusterContrast, OfEqualClustersIsTheMeanWithStudentsInterval) {
  const Estimate e = solve_contrast({{{{1.0, 2.0, 6.0}, {1.0, 1.0, 1.0}, 1.0}}, {}});
  EXPECT_DOUBLE_EQ(e.value, 3.0);
  const double error = std::sqrt((4.0 + 1.0 + 9.0) / 2.0 / 3.0);  // standard deviation / sqrt(3)
  EXPECT_NEAR(e.standard_error, error, 1e-12);
  EXPECT_NEAR(e.low(), 3.0 - 4.302652730 * error, 1e-9);
  EXPECT_NEAR(e.high(), 3.0 + 4.302652730 * error, 1e-9);
  EXPECT_EQ(e.clusters, 3u);
}

TEST(ClusterContrast, WhatClustersShareCancelsInADifferenceAndInAQuotient) {
  const std::vector<double> one{1.0, 1.0, 1.0}, a{5.0, 50.0, 500.0}, b{6.0, 51.0, 501.0}, c{7.5, 75.0, 750.0};
  const Estimate difference = solve_contrast({{{b, one, 1.0}, {a, one, -1.0}}, {}});
  EXPECT_NEAR(difference.value, 1.0, 1e-9);
  EXPECT_NEAR(difference.standard_error, 0.0, 1e-9);
  const Estimate quotient = solve_contrast({{{c, one, 1.0}}, {{a, one, 1.0}}});
  EXPECT_NEAR(quotient.value, 1.5, 1e-12);
  EXPECT_NEAR(quotient.standard_error, 0.0, 1e-9);
}

TEST(ClusterContrast, AClusterWithoutSamplesIsNotCountedAndOneAloneHasNoInterval) {
  const Estimate two = solve_contrast({{{{2.0, 0.0, 4.0}, {1.0, 0.0, 1.0}, 1.0}}, {}});
  EXPECT_EQ(two.clusters, 2u);
  EXPECT_DOUBLE_EQ(two.value, 3.0);
  const Estimate alone = solve_contrast({{{{2.0, 0.0}, {1.0, 0.0}, 1.0}}, {}});
  EXPECT_EQ(alone.clusters, 1u);
  EXPECT_DOUBLE_EQ(alone.value, 2.0);
  EXPECT_TRUE(std::isnan(alone.low()));
  EXPECT_TRUE(std::isnan(solve_contrast({{{{0.0}, {0.0}, 1.0}}, {}}).value));
  EXPECT_TRUE(std::isnan(solve_contrast({}).value));
}

}  // namespace
}  // namespace trilat
