// SPDX-License-Identifier: MIT
#include "evaluators/metrics/ratio_change.h"

#include <cmath>

#include <gmock/gmock.h>

#include "datasets/base/philox.h"

namespace trilat {
namespace {

std::vector<double> noisy(double level, std::size_t n, std::uint64_t seed) {
  std::vector<double> values;
  const RandomStream random{seed, Purpose::test, 0};
  for (std::size_t i = 0; i < n; ++i)
    values.push_back(level * std::exp(0.05 * random.normal(static_cast<std::uint32_t>(i))));
  return values;
}

TEST(QuantileOf, IsTheOneByPencil) {
  EXPECT_DOUBLE_EQ(quantile_of({4.0, 1.0, 3.0, 2.0}, 0.25), 1.75);
  EXPECT_DOUBLE_EQ(quantile_of({4.0, 1.0, 3.0, 2.0}, 1.0), 4.0);
  EXPECT_DOUBLE_EQ(quantile_of({7.0}, 0.3), 7.0);
  EXPECT_TRUE(std::isnan(quantile_of({}, 0.5)));
}

TEST(RatioChange, OfExactMultiplesIsExact) {
  const std::vector<double> before{1.0, 1.0, 1.0, 1.0}, now{1.5, 1.5, 1.5, 1.5};
  const RatioChange c = solve_ratio_change(now, before, {0.25, 2, 100, 1});
  EXPECT_DOUBLE_EQ(c.change, 0.5);
  EXPECT_DOUBLE_EQ(c.low, 0.5);
  EXPECT_DOUBLE_EQ(c.high, 0.5);
  EXPECT_EQ(c.chance, 0.0);
  EXPECT_EQ(solve_ratio_change(now, now, {0.25, 2, 100, 1}).chance, 1.0);
}

TEST(RatioChange, IsFoundThroughDisturbedStretches) {
  std::vector<double> before = noisy(1.0, 480, 1), now = noisy(1.1, 480, 2);
  for (std::size_t i = 0; i < 192; ++i) before[i] *= 1.4;  // something else ran
  const RatioChange c = solve_ratio_change(now, before, {});
  EXPECT_NEAR(c.change, 0.1, 0.04);
  EXPECT_LT(c.chance, 1e-3);
  EXPECT_LT(c.low, c.change);
  EXPECT_GT(c.high, c.change);
}

TEST(RatioChange, IsNoneBetweenTwoDrawsOfTheSame) {
  int small = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed)
    small += solve_ratio_change(noisy(1.0, 240, 2 * seed), noisy(1.0, 240, 2 * seed + 1), {0.25, 24, 200, 1})
                 .chance < 0.01;
  EXPECT_LE(small, 3);
}

TEST(RatioChange, NeedsTwoBlocksOfPositiveRatios) {
  EXPECT_TRUE(std::isnan(solve_ratio_change(noisy(1.0, 47, 1), noisy(1.0, 96, 2), {}).change));
  std::vector<double> broken = noisy(1.0, 96, 1);
  broken[3] = -1.0;
  EXPECT_TRUE(std::isnan(solve_ratio_change(broken, noisy(1.0, 96, 2), {}).change));
}

}  // namespace
}  // namespace trilat
