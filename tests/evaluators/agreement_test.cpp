// SPDX-License-Identifier: MIT
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "evaluators/metrics/statistics.h"

namespace trilat {
namespace {

DifferenceSums differences_of(const std::vector<double>& differences) {
  DifferenceSums sums;
  for (const double d : differences) {
    ++sums.n;
    sums.sum += d;
    sums.sum2 += d * d;
  }
  return sums;
}

// Three persons with 3, 2 and 4 differences: the mean squares are 0.1875 within and 3.4375 between persons,
// 2.889 measurements of each count, so the variance between persons is 1.125.
TEST(Agreement, LimitsAreThoseThatFollowByHand) {
  const std::vector<DifferenceSums> persons{differences_of({1.0, 2.0, 1.5}), differences_of({0.0, 0.5}),
                                            differences_of({2.0, 3.0, 2.5, 2.5})};
  const Agreement a = limits_of_agreement(persons);
  EXPECT_EQ(a.persons, 3u);
  EXPECT_NEAR(a.bias, 5.0 / 3.0, 1e-12);
  EXPECT_NEAR(a.sd, std::sqrt(1.125 + 0.1875), 1e-12);
  EXPECT_NEAR(a.lower, -0.5787954238616948, 1e-9);
  EXPECT_NEAR(a.upper, 3.9121287571950285, 1e-9);
  EXPECT_NEAR(a.bias_low, -1.133732674110701, 1e-8);
  EXPECT_NEAR(a.bias_high, 4.467066007444035, 1e-8);
  EXPECT_NEAR(a.upper_high - a.upper, 5.20481779108098, 1e-7);
  EXPECT_NEAR(a.lower - a.lower_low, 5.20481779108098, 1e-7);
}

TEST(Agreement, OfOnePersonThereAreLimitsWithoutIntervals) {
  const std::vector<DifferenceSums> one{differences_of({1.0, 3.0}), {}};
  const Agreement a = limits_of_agreement(one);
  EXPECT_NEAR(a.bias, 2.0, 1e-12);
  EXPECT_NEAR(a.upper - a.bias, 1.96 * std::sqrt(2.0), 1e-12);
  EXPECT_TRUE(std::isnan(a.bias_low) && std::isnan(a.upper_high));
  EXPECT_TRUE(std::isnan(limits_of_agreement({}).bias));
}

// 400 studies of 12 persons, 20 differences each, with sd 2 between and 1 within persons.
TEST(Agreement, LimitsHold95PercentOfDifferencesAndIntervalsTheLimits) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const double limit = 1.0 + 1.96 * std::sqrt(5.0);
  int held = 0;
  double upper = 0.0;
  constexpr int kStudies = 400;
  for (int study = 0; study < kStudies; ++study) {
    std::vector<DifferenceSums> persons;
    for (int p = 0; p < 12; ++p) {
      const double own = 1.0 + 2.0 * normal(random);
      std::vector<double> differences;
      for (int k = 0; k < 20; ++k) differences.push_back(own + normal(random));
      persons.push_back(differences_of(differences));
    }
    const Agreement a = limits_of_agreement(persons);
    upper += a.upper / kStudies;
    held += a.upper_low <= limit && limit <= a.upper_high ? 1 : 0;
  }
  EXPECT_NEAR(upper, limit, 0.25);
  EXPECT_GE(held, kStudies * 90 / 100);
  EXPECT_LE(held, kStudies * 99 / 100);
}

}  // namespace
}  // namespace trilat
