// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>

#include "reports/figures/figures.h"
#include "reports/render/latex.h"
#include "reports/render/render.h"
#include "reports/tables/calibration_findings.h"
#include "reports/tables/tables.h"
#include "tests/reports/calibration_summaries.h"

namespace trilat {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

std::vector<std::string> texts_of(const std::vector<TableValue>& row) {
  std::vector<std::string> texts;
  for (const TableValue& value : row)
    texts.push_back(printed(value) +
                    (printed_interval(value).empty() ? "" : " (" + printed_interval(value) + ")"));
  return texts;
}

// Everything NaN or empty that a study can leave.
CalibrationSummary unanswered_calibration() {
  CalibrationSummary s;
  s.wand = {{"ours", "far wall", {}, {}, {}, {}}, {"corrected", "far wall", {}, {}, {}, {}}};
  s.wand_samples = {{0, 0, 1.0, 0.1, ErrorSpread::kNone}};
  DistortionCurve blind;
  blind.valid = {0};
  for (auto* values :
       {&blind.depth_error_m, &blind.depth_residual_m, &blind.printed_error_m, &blind.lens_error_m})
    *values = {ErrorSpread::kNone};
  s.distortion = {blind, {}};
  s.rigs = {{}, {"wand", 1, 1, {}}};
  return s;
}

TEST(CalibrationTables, ThePapersStatementIsTheFirstRowOfTheWand) {
  const Table table = calibration_wand_table(hand_made_calibration());
  ASSERT_THAT(table.rows, SizeIs(4));
  EXPECT_THAT(texts_of(table.rows[0]),
              ElementsAre("the paper, measured", "laser meter", "50", "–", "0.73", "0.85", "–", "–", "100",
                          "–", "–", "–", "–", "–", "20.0", "not stated"));
}

TEST(CalibrationTables, AWandRowIsInCentimetresWithItsCoverage) {
  const Table table = calibration_wand_table(hand_made_calibration());
  EXPECT_THAT(
      texts_of(table.rows[3]),
      ElementsAre("ours", "far wall", "4", "3", "0.80 (0.40 to 1.20)", "0.40", "2.00 (1.00 to 3.00)", "1.00",
                  "8", "6", "4.00", "4.00", "8.00", "0", "20.0", "found 75.0 %, no_wand 25.0 %"));
}

TEST(CalibrationTables, AnErratumsNoteHasTheStudysOwnNumbers) {
  EXPECT_THAT(
      calibration_wand_table(hand_made_calibration()).notes,
      Contains(AllOf(
          HasSubstr("E2: "), HasSubstr("up to 8.00 cm sideways"),
          HasSubstr(
              "3 of 4 answered, mean error 6.00 cm (corrected: 3 of 4 answered, mean error 4.00 cm)"))));
  EXPECT_THAT(calibration_wand_table(hand_made_calibration()).notes, Not(Contains(HasSubstr("E3: "))));
}

TEST(CalibrationTables, ASampleOnAnEdgeCountsInTheBinAboveIt) {
  const Table table = calibration_bins_table(hand_made_calibration());
  ASSERT_THAT(table.rows, SizeIs(20));
  EXPECT_THAT(texts_of(table.rows[0]),
              ElementsAre("ours", "far wall", "distance (m)", "0.4", "0.8", "1", "1", "5.00", "10.00"));
  EXPECT_THAT(texts_of(table.rows[1]),
              ElementsAre("ours", "far wall", "distance (m)", "0.8", "1.5", "2", "2", "2.00", "3.00"));
  EXPECT_THAT(texts_of(table.rows[5]),
              ElementsAre("ours", "far wall", "distance (m)", "3.75", "4.5", "1", "0", "–", "–"));
  EXPECT_THAT(texts_of(table.rows[8]),
              ElementsAre("ours", "far wall", "angle (degrees)", "18", "26", "2", "2", "2.00", "3.00"));
}

TEST(CalibrationTables, AWallsEdgesAreComparedWithItsMiddle) {
  const Table table = calibration_distortion_table(hand_made_calibration());
  ASSERT_THAT(table.rows, SizeIs(2));
  EXPECT_THAT(texts_of(table.rows[0]),
              Contains(HasSubstr("columns 0 to 150 and 350 to 520: \"much higher\"")));
  // (511 * 30 mm + 80 mm) / 512 sideways on average
  EXPECT_THAT(texts_of(table.rows[1]),
              ElementsAre("unit 0", "-8.00", "20.00", "10.00", "20.00", "2.00", "4.00", "1.00", "4.00",
                          "4.00", "30.10", "80.00", "6.00", "50.0", ""));
}

TEST(CalibrationTables, ColumnsWithoutADepthDoNotCount) {
  std::vector<double> by_column(512, 1.0);
  by_column[0] = ErrorSpread::kNone;
  by_column[511] = 2.0;
  const ColumnMeans means = column_means(by_column);
  EXPECT_DOUBLE_EQ(means.left, 1.0);
  EXPECT_DOUBLE_EQ(means.right, 162.0 / 161.0);
  EXPECT_DOUBLE_EQ(means.edge, 311.0 / 310.0);
  EXPECT_TRUE(std::isnan(column_means({}).middle));
}

TEST(CalibrationTables, ARigsRowCountsSensorsWithoutAPose) {
  const Table table = calibration_rigs_table(hand_made_calibration());
  ASSERT_THAT(table.rows, SizeIs(1));
  EXPECT_THAT(texts_of(table.rows[0]),
              ElementsAre("wand", "3", "12", "2", "0.50 (0.25 to 0.75)", "1.00", "1.50", "0.50", "1.50",
                          "75.0", "90.0 (85.0 to 95.0)", "1.04", "0.97", "6.2", "1.03"));
}

TEST(CalibrationTables, EveryTitleSaysSimulated) {
  const auto tables = calibration_tables(hand_made_calibration());
  EXPECT_THAT(tables, SizeIs(4));
  for (const Table& table : tables) EXPECT_THAT(table.title, HasSubstr("simulated"));
  const auto figures = calibration_figures(hand_made_calibration());
  EXPECT_THAT(figures, SizeIs(2));
  for (const Figure& figure : figures) EXPECT_THAT(figure.title, HasSubstr("simulated"));
}

TEST(CalibrationTables, AStudyWithoutPartsHasNoTablesAndNoFigures) {
  EXPECT_THAT(calibration_tables({}), IsEmpty());
  EXPECT_THAT(calibration_figures({}), IsEmpty());
  EXPECT_THAT(calibration_sentences({}), ElementsAre(HasSubstr("The paper states")));
}

TEST(CalibrationTables, WhatIsNotKnownIsADashAndNotANan) {
  const CalibrationSummary s = unanswered_calibration();
  const auto tables = calibration_tables(s);
  EXPECT_THAT(tables, SizeIs(4));
  for (const Table& table : tables) {
    EXPECT_THAT(markdown_of(table), Not(HasSubstr("nan")));
    EXPECT_THAT(csv_of(table), Not(HasSubstr("nan")));
    EXPECT_THAT(latex_of(table), Not(HasSubstr("nan")));
  }
  for (const std::string& sentence : calibration_sentences(s)) EXPECT_THAT(sentence, Not(HasSubstr("nan")));
  for (const Figure& figure : calibration_figures(s)) {
    EXPECT_THAT(csv_of(figure), Not(HasSubstr("nan")));
    EXPECT_THAT(figure.caption, Not(HasSubstr("nan")));
  }
}

TEST(CalibrationFigures, AMethodWithoutAnAnswerAloneIsShownInTheRoom) {
  CalibrationSummary s = hand_made_calibration();
  s.wand[1].all = spread_around(0.0, 0, 8);
  s.wand.push_back(wand_row_of("corrected", 0.5));
  s.wand.back().scene = "room";
  s.wand_samples.push_back({3, 0, 2.0, 0.1, 1.5, 0.5});
  const Figure figure = calibration_figures(s).front();
  EXPECT_THAT(figure.panels, ElementsAre("ours, far wall", "corrected, in the room"));
  const auto corrected =
      std::ranges::find_if(figure.series, [](const FigureSeries& curve) { return curve.panel == 1; });
  ASSERT_NE(corrected, figure.series.end());
  ASSERT_THAT(corrected->points, SizeIs(1));
  EXPECT_DOUBLE_EQ(corrected->points.front().y, 50.0);  // of the distance, as the paper measured it
}

// Bins of 0.25 m, ranges of the angle to 9, 18, 26 and 40 degrees.
TEST(CalibrationFigures, ACurveHoldsTheMedianErrorOfTheDistanceOfOneRangeOfAngles) {
  CalibrationSummary s = hand_made_calibration();
  s.wand_samples = {{2, 0, 0.55, 0.0, 0.5, 0.01},
                    {2, 1, 0.70, 5 * kRadPerDegree, 0.5, 0.03},
                    {2, 2, 0.85, 27 * kRadPerDegree, 0.5, 0.02},
                    {2, 2, 1.15, 1 * kRadPerDegree, ErrorSpread::kNone, ErrorSpread::kNone},
                    {0, 2, 0.75, 1 * kRadPerDegree, 0.5, 0.5}};
  const Figure figure = calibration_figures(s).front();
  ASSERT_THAT(figure.series, SizeIs(2));
  EXPECT_EQ(figure.series[0].name, "0 to 9°");
  ASSERT_THAT(figure.series[0].points, SizeIs(1));  // without an answer there is no point
  EXPECT_DOUBLE_EQ(figure.series[0].points[0].x, 0.625);
  EXPECT_DOUBLE_EQ(figure.series[0].points[0].y, 2.0);  // the median of 1 and 3 cm
  EXPECT_EQ(figure.series[1].name, "26 to 40°");
  EXPECT_DOUBLE_EQ(figure.series[1].points.at(0).y, 2.0);
}

}  // namespace
}  // namespace trilat
