// SPDX-License-Identifier: MIT
#include <cmath>

#include <gmock/gmock.h>

#include "pipeline/gate/compare_results.h"

namespace trilat {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

using Rows = std::vector<Number>;

Number row(const char* measure, const char* statistic, double value, const char* method = "a") {
  return {{.group = "head", .method = method, .measure = measure, .statistic = statistic}, value};
}

GateReport compared(const Rows& before, const Rows& now, NumberRule rule = NumberRule::judge) {
  Numbers was, is;
  for (const Number& number : before) was.add(number);
  for (const Number& number : now) is.add(number);
  GateReport report;
  compare_numbers("sweep", was, is, rule, {}, report);
  return report;
}

TEST(GateNumbers, WhatIsWorseByMoreThanTheSmallestEffectIsAnAlarm) {
  const Rows before{row("distance", "p95", 0.1), row("answered", "share", 0.9)};
  GateReport report = compared(before, {row("distance", "p95", 0.11), row("answered", "share", 0.9)});
  ASSERT_THAT(report.findings, SizeIs(1));
  EXPECT_TRUE(report.findings[0].alarm);
  EXPECT_NEAR(report.findings[0].percent, 10.0, 1e-9);
  EXPECT_EQ(report.findings[0].what, "distance p95, a, head");
  EXPECT_EQ(report.findings[0].unit, "m");
  EXPECT_EQ(report.looked_at, 2u);
  report = compared(before, {row("distance", "p95", 0.09), row("answered", "share", 0.8)});
  ASSERT_THAT(report.findings, SizeIs(2));  // the alarm first
  EXPECT_EQ(report.findings[0].what, "answered share, a, head");
  EXPECT_EQ(report.findings[0].direction, Direction::worse);
  EXPECT_TRUE(report.findings[0].alarm);
  EXPECT_EQ(report.findings[1].direction, Direction::better);
  EXPECT_FALSE(report.findings[1].alarm);
  for (const GateFinding& f :
       compared(before, {row("distance", "p95", 0.2), row("answered", "share", 0.1)}, NumberRule::list)
           .findings)
    EXPECT_FALSE(f.alarm) << f.what;
}

TEST(GateNumbers, WhatIsNeitherBetterNorWorseIsListed) {
  const GateReport report = compared({row("status", "converged", 0.5), row("x", "bias", 0.01)},
                                     {row("status", "converged", 0.6), row("x", "bias", -0.01)});
  ASSERT_THAT(report.findings, SizeIs(2));
  for (const GateFinding& f : report.findings) {
    EXPECT_EQ(f.direction, Direction::changed) << f.what;
    EXPECT_FALSE(f.alarm) << f.what;
  }
}

TEST(GateNumbers, WhatDiffersByLessThanItsLimitIsCountedAndNotListed) {
  GateReport report = compared(
      {row("distance", "median", 0.1), row("distance", "p95", 0.2), row("distance", "rms", 0.1)},
      {row("distance", "median", 0.1005), row("distance", "p95", 0.22), row("distance", "rms", 0.1 + 1e-12)});
  ASSERT_THAT(report.findings, SizeIs(1));
  EXPECT_EQ(report.findings[0].what, "distance p95, a, head");
  EXPECT_EQ(report.within_limits, 1u);
  EXPECT_EQ(report.looked_at, 3u);
}

TEST(GateNumbers, RowsAreComparedByTheirKeys) {
  const GateReport report = compared({row("distance", "p95", 0.1)},
                                     {row("distance", "p95", 0.3, "new"), row("distance", "p95", 0.1)});
  ASSERT_THAT(report.findings, SizeIs(1));
  EXPECT_EQ(report.findings[0].what, "distance p95, new, head");
  EXPECT_FALSE(report.findings[0].alarm);
}

// Of nothing there is no share: 0 to 1e-18 is no change, and 0 to a length is one without a percentage.
TEST(GateNumbers, NearZeroAChangeIsAbsolute) {
  EXPECT_THAT(compared({row("distance", "p95", 0.0)}, {row("distance", "p95", 1e-18)}).findings, IsEmpty());
  const GateReport larger = compared({row("distance", "p95", 0.0)}, {row("distance", "p95", 0.02)});
  ASSERT_THAT(larger.findings, SizeIs(1));
  EXPECT_TRUE(larger.findings[0].alarm);
  EXPECT_TRUE(std::isnan(larger.findings[0].percent));
}

// Numbers of one take, and those that say how sure others are.
TEST(GateNumbers, OfOneTakeAndOfIntervalsAreNoNews) {
  Number of_take = row("distance", "p95", 0.1);
  of_take.take = "t1";
  Number changed = of_take;
  changed.value = 0.2;
  EXPECT_THAT(
      compared({of_take, row("iterations", "mean", 4.0), row("x", "sd", 0.1), row("distance", "p25", 0.1)},
               {changed, row("iterations", "mean", 9.0), row("x", "sd", 0.2), row("distance", "p25", 0.2)})
          .findings,
      IsEmpty());
}

// Mean errors and answers of an accuracy study are judged by its takes.
TEST(GateNumbers, WhatTakesJudgeIsNotListedAgain) {
  const Rows before{row("distance", "mean", 0.1), row("answered", "share", 0.9), row("distance", "p95", 0.2)},
      now{row("distance", "mean", 0.2), row("answered", "share", 0.5), row("distance", "p95", 0.3)};
  const GateReport report = compared(before, now, NumberRule::list_rest);
  ASSERT_THAT(report.findings, SizeIs(1));
  EXPECT_EQ(report.findings[0].what, "distance p95, a, head");
  EXPECT_FALSE(report.findings[0].alarm);
  EXPECT_EQ(compared(before, now).alarms(), 3u);
}

// A hundred are listed; of more a note says how many.
TEST(GateNumbers, TheLargestHundredAreListed) {
  const auto join_names = [](int count) {
    Rows before, now;
    for (int k = 0; k < count; ++k) {
      const std::string method = "m" + std::to_string(k);
      before.push_back(row("distance", "p95", 0.1, method.c_str()));
      now.push_back(row("distance", "p95", 0.2 + 0.001 * k, method.c_str()));
    }
    return compared(before, now);
  };
  EXPECT_THAT(join_names(100).findings, SizeIs(100));
  EXPECT_THAT(join_names(100).notes, IsEmpty());
  const GateReport more = join_names(101);
  ASSERT_THAT(more.findings, SizeIs(100));
  EXPECT_EQ(more.findings.front().what, "distance p95, m100, head");
  EXPECT_EQ(more.findings.back().what, "distance p95, m1, head");
  EXPECT_THAT(more.notes,
              testing::ElementsAre("sweep: 101 numbers differ, of which the 100 largest are listed"));
}

TEST(GateNumbers, AnErrorThatIsNotThereAnyMoreIsAnAlarm) {
  const GateReport report =
      compared({row("distance", "p95", 0.1), row("status", "diverged", 0.1)}, {row("distance", "max", 0.1)});
  ASSERT_THAT(report.findings, SizeIs(3));
  EXPECT_EQ(report.alarms(), 1u);
  EXPECT_EQ(report.findings[0].what, "distance p95, a, head");
  EXPECT_TRUE(std::isnan(report.findings[0].now));
}

}  // namespace
}  // namespace trilat
