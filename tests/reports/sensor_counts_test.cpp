// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include "reports/figures/figures.h"
#include "reports/tables/tables.h"

namespace trilat {
namespace {

using testing::ElementsAre;

ResultsSummary with_families() {
  ResultsSummary s;
  s.campaign = "rig";
  s.simulated = true;
  s.conditions = {"walking"};
  s.alignments = {"mean"};
  s.reference = "all";
  s.methods = {"all", "single k1", "single k2", "nonlinear, 3 sensors k1+k2+k3",
               "nonlinear, 3 sensors k1+k2+k4"};
  s.families = {{"single", 1, {"single k1", "single k2"}},
                {"nonlinear, 3 sensors", 3, {s.methods[3], s.methods[4]}},
                {"all", 8, {"all"}}};
  s.family_cells = {{"nonlinear, 3 sensors", "walking", 0.06, 0.05, 0.07, 0.9}};
  for (const std::string& method : s.methods) {
    s.cells.emplace_back().method = method;
    s.differences.emplace_back().method = method;
    s.bodies.emplace_back().method = method;
  }
  return s;
}

TEST(SensorSets, NamedByTheirNumberMakeAFigure) {
  const auto figures = sensor_counts_figure(with_families());
  ASSERT_EQ(figures.size(), 1u);
  ASSERT_EQ(figures[0].series.size(), 1u);
  EXPECT_EQ(figures[0].series[0].name, "nonlinear");
  EXPECT_NEAR(figures[0].series[0].points.at(0).x, 3.0, 1e-12);
  EXPECT_NEAR(figures[0].series[0].points.at(0).y, 6.0, 1e-12);  // over what is answered
}

TEST(SensorSets, StayOutOfTheTablesOfMethodsButSingleSensorsDoNot) {
  const ResultsSummary s = without_sets(with_families());
  EXPECT_THAT(s.methods, ElementsAre("all", "single k1", "single k2"));
  EXPECT_EQ(s.cells.size(), 3u);
  EXPECT_EQ(s.differences.size(), 3u);
  EXPECT_EQ(s.bodies.size(), 3u);
}

}  // namespace
}  // namespace trilat
