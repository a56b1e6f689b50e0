// SPDX-License-Identifier: MIT
#include "evaluators/metrics/change_points.h"

#include <cmath>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/base/philox.h"
#include "evaluators/metrics/holm.h"
#include "evaluators/metrics/student.h"
#include "evaluators/metrics/student_tail.h"

namespace trilat {
namespace {

using testing::DoubleEq;
using testing::ElementsAre;
using testing::NanSensitiveDoubleEq;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

TEST(StudentTail, HasTheClosedFormsOfOneAndTwoDegrees) {
  EXPECT_NEAR(student_two_sided(1.0, 1), 0.5, 1e-14);
  for (const double t : {0.1, 1.0, 4.0, 300.0}) {
    EXPECT_NEAR(student_two_sided(t, 2), 1.0 - t / std::sqrt(2.0 + t * t), 1e-13) << t;
    EXPECT_DOUBLE_EQ(student_two_sided(-t, 2), student_two_sided(t, 2));
  }
  EXPECT_EQ(student_two_sided(0.0, 5), 1.0);
  EXPECT_EQ(student_two_sided(HUGE_VAL, 5), 0.0);
  EXPECT_TRUE(std::isnan(student_two_sided(kNone, 5)));
  EXPECT_TRUE(std::isnan(student_two_sided(1.0, 0)));
}

TEST(StudentTail, IsFivePercentBeyondTheQuantile) {
  for (const std::size_t degrees : {1u, 3u, 15u, 30u, 200u})
    EXPECT_NEAR(student_two_sided(student_quantile(degrees), degrees), 0.05, 1e-7) << degrees;
}

TEST(Holm, CorrectsStepByStep) {
  EXPECT_THAT(holm_adjusted(std::vector{0.01, 0.04, 0.03, 0.005}),
              ElementsAre(DoubleEq(0.03), DoubleEq(0.06), DoubleEq(0.06), DoubleEq(0.02)));
}

TEST(Holm, CountsOnlyWhatIsATest) {
  EXPECT_THAT(holm_adjusted(std::vector{kNone, 0.02, 0.9}),
              ElementsAre(NanSensitiveDoubleEq(kNone), DoubleEq(0.04), DoubleEq(0.9)));
  EXPECT_TRUE(holm_adjusted({}).empty());
}

std::vector<double> levels(const std::vector<std::pair<std::size_t, double>>& pieces, double sigma,
                           std::uint64_t seed) {
  std::vector<double> values;
  const RandomStream random{seed, Purpose::test, 0};
  for (const auto& [n, level] : pieces)
    for (std::size_t i = 0; i < n; ++i)
      values.push_back(level + sigma * random.normal(static_cast<std::uint32_t>(values.size())));
  return values;
}

TEST(ChangePoints, AreWhereTheLevelChangesWithoutNoise) {
  const Segmentation found = find_change_points(levels({{5, 1.0}, {1, 2.0}, {4, 1.5}}, 0.0, 1), {});
  ASSERT_EQ(found.stretches.size(), 3u);
  EXPECT_EQ(found.stretches[1].first, 5u);
  EXPECT_EQ(found.stretches[2].first, 6u);
  EXPECT_DOUBLE_EQ(found.stretches[2].level, 1.5);
  EXPECT_EQ(find_change_points(std::vector(9, 0.3), {}).stretches.size(), 1u);
}

TEST(ChangePoints, AreSeldomInvented) {
  int invented = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed)
    invented += find_change_points(levels({{60, 1.0}}, 0.01, seed), {4.0, 3}).stretches.size() > 1;
  EXPECT_LE(invented, 4);
}

TEST(ChangePoints, OfThreeSigmaAreFoundToANight) {
  int found = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const auto s = find_change_points(levels({{40, 1.0}, {10, 1.03}}, 0.01, seed), {4.0, 3}).stretches;
    found += s.size() == 2 && s[1].first >= 38 && s[1].first <= 42;
  }
  EXPECT_GE(found, 90);
}

TEST(ChangePoints, OneStrayNightIsNoLevelWhenStretchesMustBeLonger) {
  const Segmentation found = find_change_points(levels({{20, 1.0}, {1, 1.3}, {20, 1.0}}, 0.01, 3), {4.0, 3});
  EXPECT_LE(found.stretches.size(), 3u);
  EXPECT_NEAR(found.stretches.back().level, 1.0, 0.01);
  EXPECT_NEAR(found.stretches.front().level, 1.0, 0.01);
}

TEST(ChangePoints, NothingAndOneValueAreFineAndNaNIsOurBug) {
  EXPECT_TRUE(find_change_points({}, {}).stretches.empty());
  EXPECT_EQ(find_change_points(std::vector{2.0}, {}).stretches.size(), 1u);
  EXPECT_THROW(static_cast<void>(find_change_points(std::vector{1.0, kNone}, {})), InternalError);
}

}  // namespace
}  // namespace trilat
