// SPDX-License-Identifier: MIT
#include <regex>

#include <gmock/gmock.h>

#include "reports/figures/draw_figures.h"
#include "reports/figures/figures.h"

namespace trilat {
namespace {

Night night(const std::string& day, double moving_m, double calm_m) {
  return {.time = day + "T03:00:00Z",
          .program = "0.5.0",
          .mean_error_m = {{"walks: calm, walking (m)", calm_m}, {"walks: moving, walking (m)", moving_m}}};
}

TEST(HistoryFigure, DrawsWhatMovedMostFirstInCentimetresAndShadesAcceptedNights) {
  std::vector<Night> nights{night("2026-01-01", 0.04, 0.05), night("2026-01-02", 0.06, 0.051)};
  nights[0].verdict = NightVerdict::accepted;
  const std::optional<Figure> figure = history_figure(nights);
  ASSERT_TRUE(figure.has_value());
  EXPECT_THAT(figure->x_names, testing::ElementsAre("2026-01-01", "2026-01-02"));
  ASSERT_EQ(figure->series.size(), 2u);
  EXPECT_EQ(figure->series[0].name, "walks: moving, walking");
  EXPECT_EQ(figure->series[1].name, "walks: calm, walking");
  ASSERT_EQ(figure->series[0].points.size(), 2u);
  EXPECT_DOUBLE_EQ(figure->series[0].points[0].y, 4.0);
  EXPECT_DOUBLE_EQ(figure->series[0].points[1].y, 6.0);
  EXPECT_DOUBLE_EQ(figure->series[0].points[1].x, 1.0);
  ASSERT_EQ(figure->bands.size(), 1u);
  EXPECT_LT(figure->bands[0].from, 0.0);
}

// Lowest and highest value of an axis, as the script sets its range.
std::pair<double, double> range_of(const Figure& figure, const std::string& axis) {
  std::smatch found;
  const std::string script = gnuplot_script(figure);
  if (!std::regex_search(script, found, std::regex("set " + axis + "range \\[([^:]*):([^\\]]*)\\]")))
    return {0.0, 0.0};
  return {std::stod(found[1]), std::stod(found[2])};
}

TEST(GnuplotScript, PointsThatAreNotDrawnWidenNoAxis) {
  Figure figure{.id = "f", .title = "t", .caption = "c", .x_label = "x", .y_label = "y"};
  figure.series.push_back({.name = "s", .points = {{1.0, 2.0}, {3.0, 4.0}}});
  const auto x = range_of(figure, "x"), y = range_of(figure, "y");
  EXPECT_LE(x.first, 1.0);
  EXPECT_GE(x.second, 3.0);
  EXPECT_LT(x.second, 4.0);
  figure.series[0].points.push_back({100.0, kNaN});
  figure.series[0].points.push_back({kNaN, 50.0});
  EXPECT_EQ(range_of(figure, "x"), x);
  EXPECT_EQ(range_of(figure, "y"), y);
  figure.log_y = true;
  figure.series[0].points.push_back({200.0, -1.0});  // has no place on an axis of powers
  EXPECT_EQ(range_of(figure, "x"), x);
}

TEST(GnuplotScript, AnAxisOfOneValueIsAsWideAsOne) {
  Figure figure{.id = "f", .title = "t", .caption = "c", .x_label = "x", .y_label = "y"};
  figure.series.push_back({.name = "s", .points = {{1.0, 2.0}, {3.0, 2.0}}});
  const auto y = range_of(figure, "y");
  EXPECT_LE(y.second - y.first, 1.5);
  EXPECT_LT(y.first, 2.0);
  EXPECT_GT(y.second, 2.0);
}

// An interval that reaches to zero has no place on an axis of powers; on others it has.
TEST(GnuplotScript, IntervalsThatReachBelowZeroAreLeftOutOfAxesOfPowersAlone) {
  Figure figure{.id = "f", .title = "t", .caption = "c", .x_label = "x", .y_label = "y"};
  figure.series.push_back(
      {.name = "s", .points = {{1.0, 2.0, -7.0, 9.0}, {2.0, 3.0, 1.0, 30.0}, {3.0, 4.0, 2.0, 5.0}}});
  EXPECT_LE(range_of(figure, "y").first, -7.0);
  figure.log_x = true;  // along the other axis
  EXPECT_LE(range_of(figure, "y").first, -7.0);
  figure.log_x = false;
  figure.log_y = true;
  EXPECT_GT(range_of(figure, "y").first, 0.0);
  EXPECT_GE(range_of(figure, "y").second, 30.0);
}

TEST(FigureCsv, EndsOfIntervalsHaveTheUnitOfTheAxisWhereItHasOne) {
  Figure figure{.id = "f", .title = "t", .caption = "c", .x_label = "C (mm)", .y_label = "error (cm)"};
  figure.series.push_back({.name = "s", .points = {{1.0, 2.0, 1.5, 2.5}}});
  EXPECT_THAT(csv_of(figure),
              testing::StartsWith("series,C (mm),error (cm),from (cm),to (cm)\r\ns,1,2,1.5,2.5"));
  figure.y_label = "error (all) of joints";
  EXPECT_THAT(csv_of(figure), testing::HasSubstr(",from,to\r\n"));
}

TEST(HistoryFigure, ThereIsNoneOfNightsWithoutErrors) {
  EXPECT_FALSE(history_figure({}).has_value());
  EXPECT_FALSE(history_figure({{.time = "2026-01-01T03:00:00Z", .program = "0.5.0"}}).has_value());
}

TEST(HistorySentences, LeadWithTheLastNightAndSayWhichBaselineItIsHeldAgainst) {
  std::vector<Night> nights{night("2026-01-01", 0.04, 0.05), night("2026-01-02", 0.06, 0.05)};
  nights[0].verdict = NightVerdict::accepted;
  nights[0].reason = "lag is modelled";
  nights[1].verdict = NightVerdict::regression;
  nights[1].alarms = {"accuracy | walks", "coverage | walks"};
  EXPECT_THAT(history_sentences(nights),
              testing::ElementsAre("**Night 2026-01-02: 2 alarms**, the first: accuracy | walks.",
                                   "The baseline is that of 2026-01-01: lag is modelled."));
  EXPECT_THAT(
      history_sentences({nights[0]}),
      testing::ElementsAre("**Night 2026-01-01**: its results became the baseline: lag is modelled."));
}

}  // namespace
}  // namespace trilat
