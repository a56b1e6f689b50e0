// SPDX-License-Identifier: MIT
// The first screen and the tables that a report adds to those of its studies.
#include <gmock/gmock.h>

#include "reports/render/render.h"
#include "reports/report_content.h"
#include "reports/tables.h"
#include "tests/reports/made_content.h"

namespace trilat {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(Headline, OfOneStudyGivesItsQuestionAndFourAnswers) {
  ReportContent content;
  content.chapters = {chapter_of("walks")};
  Chapter& chapter = content.chapters[0];
  chapter.findings = {"1", "2", "3", "4", "5", "6"};
  chapter.sentences = {"not this"};
  chapter.warnings = {"w"};
  chapter.legend = {"a method"};
  chapter.figures = {drawn_figure("detail", false), drawn_figure("first", true)};
  const Headline headline = headline_of(content, {}, {});
  EXPECT_EQ(headline.origin, "Recorded data");
  EXPECT_EQ(headline.asked, "Which method errs least?");
  EXPECT_THAT(headline.answers, ElementsAre("1", "2", "3", "4", "And 2 more, in the studies below."));
  EXPECT_THAT(headline.warnings, ElementsAre("w"));
  EXPECT_THAT(headline.legend, ElementsAre("a method"));
  EXPECT_FALSE(chapter.figures[0].in_headline);
  EXPECT_TRUE(chapter.figures[1].in_headline);
  EXPECT_EQ(headline_text(headline),
            "Which method errs least? Recorded data.\n  - 1\n  - 2\n  - 3\n  - 4\n  - And "
            "2 more, in the studies below.\n  - 1 warning: w\n");
}

TEST(Headline, OfSeveralStudiesNamesThemAndSaysAWarningOnce) {
  ReportContent content;
  content.chapters = {chapter_of("walks"), chapter_of("swings")};
  content.chapters[0].sentences = {"s"};
  content.chapters[0].warnings = {"both", "one"};
  content.chapters[1].warnings = {"both"};
  content.chapters[1].simulated = true;
  Headline headline = headline_of(content, {}, {});
  EXPECT_EQ(headline.origin, "Simulated and recorded data");
  EXPECT_EQ(headline.asked, "Which method errs least?");
  EXPECT_THAT(headline.answers, ElementsAre("walks: s"));
  EXPECT_THAT(headline.warnings, ElementsAre("walks, swings: both", "walks: one"));
  EXPECT_THAT(headline_text(headline), HasSubstr("  - 2 warnings, the first: walks, swings: both\n"));
  content.chapters[0].simulated = true;
  content.chapters[1].asked = "Another?";
  headline = headline_of(content, {}, {});
  EXPECT_EQ(headline.origin, "Simulated data");
  EXPECT_EQ(headline.asked, "What did the studies find?");
}

TEST(Headline, BesideThePaperItsWalkingStudyAnswers) {
  ReportContent content;
  content.chapters = {chapter_of("other"), chapter_of("walks")};
  content.chapters[0].on_the_paper = {"not this"};
  content.chapters[0].figures = {drawn_figure("other", true)};
  Chapter& walks = content.chapters[1];
  walks.paper = "table3";
  walks.on_the_paper = {"No."};
  walks.figures = {drawn_figure("curves", true), drawn_figure("rows", true)};
  walks.figures[1].figure.y_names = {"mean"};
  PaperFindings paper;
  paper.claims.resize(3);
  paper.claims[1].verdict = ClaimVerdict::holds;
  const Headline headline = headline_of(content, paper, {});
  EXPECT_THAT(headline.asked, HasSubstr("better than the plain mean of them?"));
  EXPECT_THAT(headline.answers, ElementsAre("No."));
  EXPECT_THAT(headline.verdicts, ElementsAre(std::pair{ClaimVerdict::holds, std::size_t{1}},
                                             std::pair{ClaimVerdict::cannot_test, std::size_t{2}}));
  EXPECT_TRUE(walks.figures[1].in_headline);
  EXPECT_FALSE(walks.figures[0].in_headline);
  EXPECT_FALSE(content.chapters[0].figures[0].in_headline);
  EXPECT_THAT(headline_text(headline),
              HasSubstr("  - The paper's claims: holds 1, cannot be tested here 2.\n"));
  walks.simulated = true;
  EXPECT_THAT(headline_of(content, paper, {}).answers.back(),
              HasSubstr("No. Recorded, for comparison: one real Kinect v2 against motion capture"));
  walks.on_the_paper.clear();
  EXPECT_EQ(headline_of(content, paper, {}).asked, "Which method errs least?");
}

ErrorChanges two_changes() {
  const ErrorChange small{.condition = "walking",
                          .group = "average",
                          .method = "mean",
                          .before_m = 0.05,
                          .after_m = 0.09,
                          .difference_m = 0.04,
                          .low_m = -0.01,
                          .high_m = 0.09};
  ErrorChange better = small, worse = small, larger = small;
  better.difference_m = -0.01;
  better.low_m = -0.02;
  better.high_m = -0.005;
  worse.method = "linear";
  worse.difference_m = 0.02;
  worse.low_m = 0.01;
  worse.high_m = 0.03;
  larger.difference_m = 0.05;
  return {
      .before = "a", .after = "b", .paired = true, .participants = 3, .rows = {small, better, larger, worse}};
}

TEST(Changes, RealOnesStandFirstTheLargestAtTheTop) {
  const Table table = changes_table(two_changes());
  std::vector<std::string> differs;
  for (const auto& row : table.rows) differs.push_back(printed(row[4]) + " " + row[5].text);
  EXPECT_THAT(differs, ElementsAre("2.00 worse", "-1.00 better", "5.00 no", "4.00 no"));
  EXPECT_EQ(table.rows[0][5].mark, TableValue::Mark::bad);
  EXPECT_EQ(table.rows[1][5].mark, TableValue::Mark::good);
  EXPECT_EQ(table.rows[2][5].mark, TableValue::Mark::none);
  EXPECT_EQ(table.title, "What changed from a to b: mean error in cm (3 participants, the same in both)");
  EXPECT_THAT(
      changes_sentences(two_changes()),
      ElementsAre("From `a` to `b` the mean error of **2 of 4** methods and conditions changed beyond its "
                  "interval.",
                  "`linear`, walking: +2.00 cm (+1.00 to +3.00), from 5.00 to 9.00.",
                  "`mean`, walking: -1.00 cm (-2.00 to -0.50), from 5.00 to 9.00."));
  ReportContent content;
  content.chapters = {chapter_of("a"), chapter_of("b")};
  content.chapters[1].figures = {drawn_figure("f", true)};
  const Headline headline = headline_of(content, {}, two_changes());
  EXPECT_EQ(headline.asked, "What changed, by how much, and is it real?");
  EXPECT_EQ(headline.answers.size(), 3u);
  EXPECT_TRUE(content.chapters[1].figures[0].in_headline);
}

TEST(Claims, NumbersHaveAsManyDigitsAsTheyNeed) {
  const auto text = [](double value, double low = kNaN, double high = kNaN, double compared = 1.0) {
    return numbers_text(
        {{.what = "w", .unit = "%", .value = value, .low = low, .high = high, .compared = compared}});
  };
  EXPECT_EQ(text(9.994), "w: 9.99 %");
  EXPECT_EQ(text(-12.34, -13, -11), "w: -12.3 % (-13.0 to -11.0)");
  EXPECT_EQ(text(99.5), "w: 99.500 %");  // near all, where a digit less would say 100
  EXPECT_EQ(text(123.4), "w: 123 %");
  EXPECT_EQ(text(kNaN), "w: no answer");
  EXPECT_EQ(text(1.0, 0.5, 1.5, 0.994), "w: 1.00 % (0.50 to 1.50), where both answer (99 % of the samples)");
  EXPECT_EQ(text(1.0, 0.5, 1.5, 0.996), "w: 1.00 % (0.50 to 1.50)");
  EXPECT_EQ(numbers_text({}), "–");
}

TEST(Claims, TheTableGivesVerdictNumbersAndRule) {
  PaperFindings findings;
  findings.claims = {
      {.id = "a",
       .where = "abstract",
       .claim = "better",
       .printed = "8.7 cm",
       .reason = "half a step",
       .numbers = {{.what = "x",
                    .unit = "cm",
                    .value = 4.0,
                    .low = 3.0,
                    .high = 5.0,
                    .over = "participants",
                    .compared = 1.0,
                    .bound = "more than 1 %"},
                   {.what = "y", .unit = "cm", .value = 2.0, .compared = 1.0, .bound = "more than 1 %"}},
       .p = 0.00005,
       .verdict = ClaimVerdict::does_not_hold},
      {.id = "n",
       .where = "",
       .claim = "none",
       .printed = "-",
       .reason = "nothing printed",
       .numbers = {},
       .p = 0.25}};
  const Table table = claims_table(findings);
  std::vector<std::string> cells;
  for (const auto& row : table.rows)
    for (const TableValue& value : row) cells.push_back(value.text);
  EXPECT_THAT(cells,
              ElementsAre("better", "does not hold", "8.7 cm", "x: 4.00 cm; y: 2.00 cm",
                          "x: 4.00 cm (3.00 to 5.00); y: 2.00 cm",
                          "more than 1 %: half a step; over participants", "< 0.0001", "abstract", "none",
                          "cannot be tested here", "-", "–", "–", "nothing printed", "0.2500", ""));
  EXPECT_EQ(table.rows[0][1].mark, TableValue::Mark::bad);
  EXPECT_EQ(table.first_columns, 4u);
  EXPECT_EQ(table.title, "The paper's claims and what becomes of them");
  EXPECT_THAT(errata_table(findings).about, IsEmpty());
  findings.evidence.any_simulated = true;
  EXPECT_EQ(claims_table(findings).title,
            "The paper's claims and what becomes of them, with simulated sensors");
  EXPECT_GT(claims_table(findings).notes.size(), table.notes.size());
  findings.evidence.errata["E1"] = "stored";
  findings.errata["E1"] = {{.what = "x", .unit = "cm", .value = 4.0, .compared = 1.0}};
  EXPECT_EQ(errata_table(findings).rows[0][5].text, "stored; x: 4.00 cm");
  EXPECT_EQ(errata_table(findings).about, "simulated");
}

TEST(Claims, WhatThePaperPrintsStandsBesideItsTableAndItsFigure) {
  Table table = errors_table();
  table.columns[1].key = "head_mae_cm";
  add_printed(table, true);
  EXPECT_EQ(table.title, "Error");  // it is not the paper's
  table.printed = "table3";
  table.rows[0][0].text = "nonlinear";
  Table recorded = table;
  add_printed(table, true);
  add_printed(recorded, false);
  EXPECT_EQ(table.title, "Table III: Error");
  EXPECT_THAT(table.rows[0][1].beside, testing::StartsWith("paper "));
  EXPECT_EQ(table.rows[1][1].beside, "");  // the paper has no mean
  EXPECT_EQ(table.rows[0][0].beside, "");
  EXPECT_GT(table.notes.size(), recorded.notes.size());
  Figure figure{.id = "f", .title = "t", .caption = "c", .x_label = "x", .y_label = "y"};
  add_printed(figure);
  EXPECT_EQ(figure.title, "t");
  figure.printed = "table3";
  figure.panels = {"head", "knee"};
  figure.y_names = {"mean", "nonlinear"};
  add_printed(figure);
  ASSERT_EQ(figure.series.size(), 1u);
  EXPECT_TRUE(figure.series[0].hollow);
  EXPECT_EQ(figure.series[0].panel, 0u);
  ASSERT_EQ(figure.series[0].points.size(), 1u);
  EXPECT_EQ(figure.series[0].points[0].y, 1.0);
  EXPECT_EQ("paper " + printed(TableValue::of(figure.series[0].points[0].x, 1)), table.rows[0][1].beside);
  EXPECT_EQ(figure.title, "t, the paper's beside ours");
}

TEST(Parameters, NoteTheirOriginUnlessTheSimulationSetSome) {
  std::vector<SimulationAssumption> parameters{{.name = "n", .value = "1", .unit = "m", .source = "a paper"}};
  Table table = parameters_table(parameters, "table3");
  EXPECT_EQ(table.title, "What the simulation behind table3 assumes, with sources");
  ASSERT_EQ(table.rows.size(), 1u);
  EXPECT_EQ(table.rows[0][3].text, "a paper");
  EXPECT_FALSE(table.notes.empty());
  parameters.push_back({.name = "m", .value = "2", .unit = "", .source = kSetInTheSimulation});
  EXPECT_TRUE(parameters_table(parameters, "table3").notes.empty());
}

TEST(Errata, AllAreListedAndWithoutAStudyNoEffectIsClaimed) {
  const Table table = errata_table({});
  ASSERT_EQ(table.rows.size(), 21u);
  for (std::size_t k = 0; k < table.rows.size(); ++k)
    EXPECT_EQ(table.rows[k][0].text, "E" + std::to_string(k + 1));
  EXPECT_EQ(table.rows[6][5].text, "its study is not among these results");
  EXPECT_EQ(table.rows[8][5].text, "none on a result");
}

TEST(Errata, TheEffectIsPrintedBesideCorrected) {
  PaperFindings findings;
  findings.errata["E8"] = {{.claim = "E8",
                            .what = "printed stop against nonlinear",
                            .unit = "%",
                            .value = 33.3,
                            .low = 30.0,
                            .high = 36.0,
                            .compared = 0.8}};
  EXPECT_EQ(errata_table(findings).rows[7][5].text,
            "printed stop against nonlinear: 33.3 % (30.0 to 36.0), where both answer (80 % of the samples)");
}

}  // namespace
}  // namespace trilat
