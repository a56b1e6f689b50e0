// SPDX-License-Identifier: MIT
#include <cmath>
#include <limits>
#include <vector>

#include <gmock/gmock.h>
#include <gsl/gsl_cdf.h>

#include "evaluators/metrics/statistics.h"

namespace trilat {
namespace {

using testing::DoubleEq;
using testing::ElementsAre;
using testing::NanSensitiveDoubleEq;

TEST(StudentTail, HasTheClosedFormsOfOneAndTwoDegrees) {
  EXPECT_NEAR(student_two_sided(1.0, 1), 0.5, 1e-14);
  for (const double t : {0.1, 1.0, 4.0, 300.0}) {
    EXPECT_NEAR(student_two_sided(t, 2), 1.0 - t / std::sqrt(2.0 + t * t), 1e-13) << t;
    EXPECT_DOUBLE_EQ(student_two_sided(-t, 2), student_two_sided(t, 2));
  }
  EXPECT_EQ(student_two_sided(0.0, 5), 1.0);
  EXPECT_EQ(student_two_sided(HUGE_VAL, 5), 0.0);
  EXPECT_TRUE(std::isnan(student_two_sided(kNaN, 5)));
  EXPECT_TRUE(std::isnan(student_two_sided(1.0, 0)));
}

TEST(StudentTail, IsFivePercentBeyondTheQuantile) {
  for (const std::size_t degrees : {1u, 3u, 15u, 30u, 200u})
    EXPECT_NEAR(student_two_sided(student_quantile(degrees), degrees), 0.05, 1e-7) << degrees;
  for (const double alpha : {0.5, 0.05, 0.05 / 18.0, 1e-9})
    EXPECT_NEAR(student_two_sided(student_quantile(7, alpha), 7) / alpha, 1.0, 1e-9) << alpha;
}

// GSL's own inverse ends the program, or returns no number, for 149 of these shapes.
TEST(GammaQuantile, IsWhereTheDistributionReachesTheProbability) {
  for (double shape = 0.5; shape < 2e5; shape *= 1.017) {
    const double quantile = gamma_quantile(0.975, shape, 2.0);
    EXPECT_NEAR(gsl_cdf_gamma_P(quantile, shape, 2.0), 0.975, 1e-9) << shape;
  }
}

TEST(Holm, CorrectsStepByStep) {
  EXPECT_THAT(holm_adjusted(std::vector{0.01, 0.04, 0.03, 0.005}),
              ElementsAre(DoubleEq(0.03), DoubleEq(0.06), DoubleEq(0.06), DoubleEq(0.02)));
}

TEST(Holm, CountsOnlyWhatIsATest) {
  EXPECT_THAT(holm_adjusted(std::vector{kNaN, 0.02, 0.9}),
              ElementsAre(NanSensitiveDoubleEq(kNaN), DoubleEq(0.04), DoubleEq(0.9)));
  EXPECT_TRUE(holm_adjusted({}).empty());
}

TEST(Shares, NeverAndAlwaysLeaveNoChanceUntold) {
  EXPECT_EQ(estimate_share(0.0, 10.0).chance_of_more(0.5), 1.0);
  EXPECT_LT(estimate_share(1.0, 10.0).chance_of_fewer(0.9), 1e-6);
  EXPECT_EQ(estimate_share(10.0, 10.0).chance_of_fewer(0.5), 1.0);
  EXPECT_NEAR(estimate_share(10.0, 10.0).chance_of_more(0.5), std::pow(0.5, 10.0), 1e-12);
}

}  // namespace
}  // namespace trilat
