// SPDX-License-Identifier: MIT
#include <cmath>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "pipeline/gate/compare_results.h"

namespace trilat {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

Json document_with(double mae_m, double digits) {
  return {{"study", "sweep"},
          {"cells",
           {{{"method", "a"}, {"mae_m", mae_m}, {"mean_digits", 9.0}},
            {{"method", "b"}, {"mae_m", 0.1}, {"mean_digits", digits}}}}};
}

std::vector<GateFinding> changes(const Json& before, const Json& now) {
  GateReport report;
  compare_numbers("sweep", before, now, true, {}, report);
  return report.findings;
}

TEST(GateNumbers, WhatDiffersByMoreThanTheSmallestEffectIsAnAlarm) {
  std::vector<GateFinding> found = changes(document_with(0.1, 9.0), document_with(0.11, 9.0));
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_TRUE(found[0].alarm);
  EXPECT_NEAR(found[0].percent, 10.0, 1e-9);
  EXPECT_EQ(found[0].what, "/cells/a/mae_m");
  found = changes(document_with(0.1, 9.0), document_with(0.09, 8.0));
  ASSERT_THAT(found, SizeIs(2));  // in either direction, the smaller change last
  EXPECT_NEAR(found[0].percent, -100.0 / 9.0, 1e-9);
  EXPECT_EQ(found[1].what, "/cells/a/mae_m");
  EXPECT_NEAR(found[1].percent, -10.0, 1e-9);
}

TEST(GateNumbers, WhatDiffersByLessThanItsLimitIsCountedAndNotListed) {
  GateReport report;
  compare_numbers("sweep", document_with(0.1, 9.0), document_with(0.1005, 9.08), true, {}, report);
  EXPECT_THAT(report.findings, testing::IsEmpty());
  EXPECT_EQ(report.within_limits, 2u);
  compare_numbers("sweep", document_with(0.1, 9.0), document_with(0.1 + 1e-12, 9.0), true, {}, report);
  EXPECT_EQ(report.within_limits, 2u);  // the same number
  Numbers before, now;
  const NumberKey key{.group = "head", .method = "a", .measure = "distance"};
  for (const auto& [statistic, was, is] :
       {std::tuple{"median", 0.1, 0.1005}, {"p95", 0.2, 0.22}, {"rms", 0.1, 0.1}}) {
    before.add({key.with({.statistic = statistic}), was});
    now.add({key.with({.statistic = statistic}), is});
  }
  report = {};
  list_numbers("walks", before, now, {}, report);
  ASSERT_THAT(report.findings, SizeIs(1));
  EXPECT_EQ(report.findings[0].what, "distance p95, a, head");
  EXPECT_EQ(report.findings[0].unit, "m");
  EXPECT_EQ(report.within_limits, 1u);
  EXPECT_EQ(report.looked_at, 3u);
}

TEST(GateNumbers, RowsAreComparedByName) {
  Json now = document_with(0.1, 9.0);
  now["cells"].insert(now["cells"].begin(), Json({{"method", "new"}, {"mae_m", 0.3}}));
  const auto found = changes(document_with(0.1, 9.0), now);
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_EQ(found[0].what, "/cells/new");
}

// Of nothing there is no share: 0 to 1e-18 is no change, and 0 to a length is one without a percentage.
TEST(GateNumbers, NearZeroAChangeIsAbsolute) {
  const auto found = changes(document_with(0.0, 0.0), document_with(1e-18, 1e-18));
  for (const GateFinding& f : found) EXPECT_FALSE(f.alarm) << f.what;
  const auto larger = changes(document_with(0.0, 9.0), document_with(0.02, 9.0));
  ASSERT_THAT(larger, SizeIs(1));
  EXPECT_TRUE(larger[0].alarm);
  EXPECT_TRUE(std::isnan(larger[0].percent));
}

TEST(GateNumbers, BoundsAndBookkeepingAreNoNews) {
  const Json before{
      {"mae_m", 0.1}, {"mae_low_m", 0.05}, {"mae_high_m", 0.2}, {"mean_iterations", 4.0}, {"p05_m", 0.01}};
  const Json now{
      {"mae_m", 0.1}, {"mae_low_m", 0.01}, {"mae_high_m", 0.4}, {"mean_iterations", 9.0}, {"p05_m", 0.05}};
  EXPECT_THAT(changes(before, now), IsEmpty());
}

TEST(GateNumbers, AValueThatIsNotThereAnyMoreOrIsAnotherKindIsAnAlarm) {
  Json now = document_with(0.1, 9.0);
  now["cells"][0]["mae_m"] = nullptr;
  now["cells"][1].erase("mean_digits");
  now["study"] = "other";
  const auto found = changes(document_with(0.1, 9.0), now);
  ASSERT_THAT(found, SizeIs(3));
  for (const GateFinding& finding : found) EXPECT_TRUE(finding.alarm) << finding.what;
}

}  // namespace
}  // namespace trilat
