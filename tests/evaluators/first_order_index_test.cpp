// SPDX-License-Identifier: MIT
#include "evaluators/metrics/first_order_index.h"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace trilat {
namespace {

struct Sample {
  std::vector<double> a, b, y;
};

// y = 2 a + b + noise, all uniform: by their variances 4/6, 1/6 and 1/6.
Sample drawn(std::size_t points, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform;
  Sample sample;
  for (std::size_t i = 0; i < points; ++i) {
    sample.a.push_back(uniform(random));
    sample.b.push_back(uniform(random));
    sample.y.push_back(2.0 * sample.a.back() + sample.b.back() + uniform(random));
  }
  return sample;
}

TEST(FirstOrderIndex, IsTheShareOfTheVariance) {
  const Sample s = drawn(4000, 1);
  EXPECT_NEAR(first_order_index(s.a, s.y).value, 4.0 / 6.0, 0.03);
  EXPECT_NEAR(first_order_index(s.b, s.y).value, 1.0 / 6.0, 0.03);
}

TEST(FirstOrderIndex, ItsIntervalHoldsTheTruthAndWhatDecidesNothingHasNone) {
  int held = 0, of_nothing = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const Sample s = drawn(100, seed);
    const VarianceShare share = first_order_index(s.a, s.y);
    held += share.low <= 4.0 / 6.0 && 4.0 / 6.0 <= share.high;
    of_nothing += first_order_index(drawn(100, seed + 1000).a, s.y).low > 0.0;
  }
  EXPECT_GE(held, 180);
  EXPECT_LE(of_nothing, 12);
}

TEST(FirstOrderIndex, OfTooFewOrOfEqualValuesNothingIsKnown) {
  EXPECT_TRUE(std::isnan(first_order_index(std::vector(7, 0.1), std::vector(7, 1.0)).value));
  EXPECT_TRUE(std::isnan(first_order_index(std::vector(50, 0.1), std::vector(50, 1.0)).value));
  Sample s = drawn(100, 3);
  for (std::size_t i = 0; i < 90; ++i) s.y[i] = std::nan("");
  EXPECT_FALSE(std::isnan(first_order_index(s.a, s.y).value));
}

}  // namespace
}  // namespace trilat
