// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "reports/figures/figures.h"
#include "reports/render/render.h"
#include "reports/tables/tables.h"
#include "tests/reports/summaries.h"

namespace trilat {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

std::size_t column(const Table& table, const std::string& key) {
  const auto found = std::ranges::find_if(table.columns, [&](const TableColumn& c) { return c.key == key; });
  EXPECT_NE(found, table.columns.end()) << key;
  return static_cast<std::size_t>(found - table.columns.begin());
}

const std::vector<TableValue>& row(const Table& table, const std::string& joint, const std::string& method) {
  for (const auto& values : table.rows)
    if (values[0].text == joint && values[1].text == method) return values;
  throw std::out_of_range(joint + " " + method);
}

double number(const Table& table, const std::string& joint, const std::string& method,
              const std::string& key) {
  return row(table, joint, method)[column(table, key)].number.value();
}

// nonlinear answers 75 %, the mean all; the average of nonlinear is 3 cm.
ResultsSummary summary_with_best() {
  ResultsSummary summary = hand_made_summary();
  for (SummaryCell& cell : summary.cells)
    std::tie(cell.mae_low_m, cell.mae_high_m) = std::pair(cell.mae_m - 0.004, cell.mae_m + 0.005);
  for (const auto& [method, m, n] : {std::tuple{"nonlinear", 0.03, 300}, {"mean", 0.05, 400}}) {
    SummaryCell average = cell_of(method, kAverageGroup, m, static_cast<std::uint64_t>(n));
    average.asked = 400;
    std::tie(average.mae_low_m, average.mae_high_m) = std::pair(m - 0.01, m + 0.02);
    summary.cells.push_back(average);
  }
  summary.best = {{"walking", "head", "mean", {"nonlinear"}}, {"walking", kAverageGroup, "mean", {}}};
  return summary;
}

const TableValue& article_cell(const Table& table, const std::string& method, const std::string& key) {
  for (const auto& values : table.rows)
    if (values[0].text == method) return values[column(table, key)];
  throw std::out_of_range(method);
}

TEST(Table3, StandsBesideThePaperWithIntervalsAndTheShareAnswered) {
  const auto tables = article_tables(summary_with_best(), true);
  ASSERT_EQ(tables.size(), 1u);
  const Table& table = tables[0];
  EXPECT_EQ(table.id, "errors-walking");
  EXPECT_THAT(table.title, AllOf(HasSubstr("Table III"), HasSubstr("simulated")));
  const TableValue& wrist = article_cell(table, "nonlinear", "wrist_mae_cm");
  EXPECT_DOUBLE_EQ(*wrist.number, 6.0);
  EXPECT_DOUBLE_EQ(wrist.low, 5.6);
  EXPECT_DOUBLE_EQ(wrist.high, 6.5);
  EXPECT_EQ(wrist.beside, "paper 14.2");
  EXPECT_EQ(article_cell(table, "nonlinear", "average_mae_cm").beside, "paper 8.7");
  EXPECT_EQ(article_cell(table, "mean", "head_mae_cm").beside, "");  // the paper has no such method
  EXPECT_EQ(*article_cell(table, "nonlinear", "answered_percent").number, 75.0);
  EXPECT_THAT(csv_of(table), HasSubstr("method,head_mae_cm,head_mae_from_cm,head_mae_to_cm,"));
  EXPECT_THAT(markdown_of(table), HasSubstr("6.0 (5.6 to 6.5); paper 14.2"));
}

TEST(Table3, TheBestIsBoldAndWhatIsNotToldApartFromItIsMarked) {
  const Table table = article_tables(summary_with_best(), false).at(0);
  EXPECT_EQ(article_cell(table, "mean", "head_mae_cm").mark, TableValue::Mark::best);
  EXPECT_EQ(article_cell(table, "nonlinear", "head_mae_cm").mark, TableValue::Mark::like_best);
  EXPECT_EQ(article_cell(table, "nonlinear", "average_mae_cm").mark, TableValue::Mark::none);
  EXPECT_EQ(article_cell(table, "nonlinear", "head_mae_cm").beside, "");  // the paper was not asked
}

TEST(Table3, OnlyWalkingRelativeToTheMeanStandsBesideThePaper) {
  ResultsSummary standing = summary_with_best(), unaligned = summary_with_best();
  standing.conditions = {"standing"};
  for (SummaryCell& cell : standing.cells) cell.condition = "standing";
  unaligned.alignments = {"none"};
  for (SummaryCell& cell : unaligned.cells) cell.alignment = "none";
  for (const ResultsSummary& summary : {standing, unaligned})
    EXPECT_THAT(article_tables(summary, true).at(0).title, testing::Not(HasSubstr("Table III")));
}

TEST(Table3, FailedTakesAreNamedUnderTheTable) {
  ResultsSummary summary = hand_made_summary();
  summary.takes_failed = 1;
  summary.notes = {{"p02-walking", true, "p02/mocap.csv:9", "is cut"}};
  const Table table = article_tables(summary, true).at(0);
  EXPECT_THAT(table.notes, testing::Contains("Take p02-walking failed: p02/mocap.csv:9: is cut."));
  EXPECT_THAT(table.title, HasSubstr("1 of 2 takes"));
}

TEST(LeadingMethods, AreThePapersTheBestSensorTheMeanAndTheBestInTheOrderOfTheirErrors) {
  ResultsSummary s = hand_made_summary();
  s.methods = {"linear", "geometric", "nonlinear", "single k1", "single k2", "a", "b", "mean", "rts", "c"};
  s.cells.clear();
  s.groups = {"head"};
  for (std::size_t m = 0; m < s.methods.size(); ++m)
    s.cells.push_back(cell_of(s.methods[m], "head", 0.10 - 0.01 * static_cast<double>(m)));
  s.best = {{"walking", "head", "c", {}}};
  EXPECT_THAT(leading_methods(s, "walking"),
              ElementsAre("c", "mean", "single k2", "nonlinear", "geometric", "linear"));
  const Table table = article_tables(s, false).at(0);
  EXPECT_EQ(table.first_rows, 6u);
  EXPECT_EQ(table.rows.size(), 10u);
}

// Seven takes at 5.0 to 5.6 cm and one at 9 cm.
// Eight takes of about 5 cm, of which the last has 9.
ResultsSummary with_an_odd_take() {
  ResultsSummary s = hand_made_summary();
  for (int k = 0; k < 8; ++k)
    s.by_take.push_back({fmt::format("t{}", k),
                         "p1",
                         "walking",
                         "wrist",
                         k == 0 ? "wrist_right" : "wrist_left",
                         "mean",
                         10,
                         10,
                         k == 7 ? 0.09 : 0.05 + 0.001 * k,
                         {},
                         {},
                         {}});
  s.best = {{"walking", kAverageGroup, "mean", {}}};
  return s;
}

TEST(Oddities, TheTakeThatIsFarFromTheOthersComesFirstAndIsCalledOdd) {
  const std::vector<Table> tables = oddity_tables(with_an_odd_take());
  ASSERT_EQ(tables.size(), 1u);
  EXPECT_EQ(tables[0].rows[0][0].text, "t7");
  EXPECT_EQ(tables[0].rows[0].back().text, "odd");
  EXPECT_EQ(tables[0].rows[1].back().text, "");
}

TEST(Oddities, ATakeWithoutAnyAnswerComesBeforeAllOthers) {
  ResultsSummary s = with_an_odd_take();
  for (const std::size_t silent : {3u, 5u}) {
    s.by_take[silent].answered = 0;
    s.by_take[silent].mae_m = kNoNumber;
  }
  const Table table = oddity_tables(s).at(0);
  std::vector<std::string> takes, odd;
  for (const auto& row : table.rows) {
    takes.push_back(row.front().text);
    odd.push_back(row.back().text);
  }
  EXPECT_EQ(std::vector(takes.begin(), takes.begin() + 3), (std::vector<std::string>{"t3", "t5", "t7"}));
  EXPECT_EQ(std::vector(odd.begin(), odd.begin() + 4),
            (std::vector<std::string>{"no answer", "no answer", "odd", ""}));
}

TEST(AccuracyTables, RareStatusesAreNeitherHiddenNorRoundedToAll) {
  ResultsSummary summary = hand_made_summary();
  summary.cells[0].asked = 10'000;
  summary.cells[0].answered = 9'999;
  summary.cells[0].statuses = {{"clamped", 0}, {"converged", 9'999}, {"diverged", 1}};
  summary.cells[0].statuses.erase("clamped");
  const Table table = accuracy_tables(summary).at(0);
  EXPECT_EQ(row(table, "head", "nonlinear").back().text, "converged >99.9 %, diverged <0.1 %");
}

TEST(AccuracyTables, OneTableForEachConditionAndAlignmentThatHasCells) {
  ResultsSummary summary = hand_made_summary();
  summary.conditions = {"walking", "standing"};
  summary.alignments = {"mean", "none"};
  SummaryCell other = cell_of("mean", "knee", 0.123);
  other.condition = "standing";
  other.alignment = "none";
  other.axis_mae_m = {0.01, 0.02, 0.03};
  summary.cells.push_back(other);
  const auto tables = accuracy_tables(summary);
  ASSERT_EQ(tables.size(), 2u);
  EXPECT_EQ(tables[0].id, "accuracy-walking-mean");
  EXPECT_EQ(tables[0].rows.size(), 8u);
  EXPECT_EQ(tables[1].id, "accuracy-standing-none");
  EXPECT_THAT(tables[1].title, HasSubstr("alignment: none"));
  EXPECT_DOUBLE_EQ(number(tables[1], "knee", "mean", "mae_cm"), 12.3);
  EXPECT_DOUBLE_EQ(number(tables[1], "knee", "mean", "mae_z_cm"), 3.0);
  EXPECT_EQ(printed(row(tables[1], "knee", "mean")[column(tables[1], "rmse_cm")]), "–");
}

DifferenceCell difference(const std::string& method, double difference_m, double low_m, double high_m) {
  DifferenceCell d;
  d.method = method;
  d.condition = "walking";
  d.group = "head";
  d.alignment = "mean";
  d.n = 70;
  d.clusters = 2;
  d.difference_m = difference_m;
  d.low_m = low_m;
  d.high_m = high_m;
  d.percent_of_reference = -25.0;
  d.percent_of_method = -100.0 / 3.0;
  return d;
}

TEST(AccuracyTables, WhoAnswersLittleIsNamedWithTheReason) {
  ResultsSummary summary = hand_made_summary();
  const auto tables = accuracy_tables(summary);
  EXPECT_THAT(tables[0].notes, testing::Contains(AllOf(HasSubstr("nonlinear 75 % (too_few_ranges 25 %)"),
                                                       testing::Not(HasSubstr("mean 100 %")))));
  for (SummaryCell& cell : summary.cells) cell.answered = cell.asked;
  EXPECT_THAT(accuracy_tables(summary)[0].notes,
              testing::Not(testing::Contains(HasSubstr("less than 80 %"))));
}

TEST(AccuracyTables, AMethodThatAnswersLittleIsBetterOnlyWhereItAnswers) {
  ResultsSummary summary = hand_made_summary();
  summary.reference = "mean";
  summary.differences = {difference("nonlinear", -0.01, -0.02, -0.005)};
  EXPECT_EQ(row(accuracy_tables(summary)[1], "head", "nonlinear").back().text,
            "better, where it answers (75 %)");
}

TEST(AccuracyTables, EachJointOfEachTakeIsARow) {
  ResultsSummary summary = hand_made_summary();
  summary.by_take = {{"a", "p1", "walking", "wrist", "wrist_left", "mean", 20, 10, 0.02, {}, {}},
                     {"a", "p1", "walking", "wrist", "wrist_right", "mean", 20, 0, kNoNumber, {}, {}}};
  const auto tables = apart_tables(summary);
  ASSERT_EQ(tables.size(), 1u);
  ASSERT_EQ(tables[0].rows.size(), 2u);
  EXPECT_DOUBLE_EQ(*tables[0].rows[0][column(tables[0], "mae_cm")].number, 2.0);
  EXPECT_DOUBLE_EQ(*tables[0].rows[0][column(tables[0], "coverage_percent")].number, 50.0);
  EXPECT_EQ(printed(tables[0].rows[1][column(tables[0], "mae_cm")]), "–");
}

TEST(AccuracyTables, DifferencesSayWhichMethodIsBetterAndInBothConventions) {
  ResultsSummary summary = hand_made_summary();
  summary.reference = "nonlinear";
  summary.resamples = 2000;
  summary.block_s = 1.0;
  summary.differences = {difference("b", -0.01, -0.02, -0.005), difference("w", 0.01, 0.005, 0.02),
                         difference("n", 0.01, -0.005, 0.02), difference("-", 0.01, kNoNumber, kNoNumber)};
  const auto tables = accuracy_tables(summary);
  ASSERT_EQ(tables.size(), 2u);
  const Table& table = tables[1];
  EXPECT_EQ(table.id, "differences-walking-mean");
  EXPECT_THAT(table.title, HasSubstr("method less \"nonlinear\""));
  EXPECT_DOUBLE_EQ(number(table, "head", "b", "difference_cm"), -1.0);
  EXPECT_DOUBLE_EQ(row(table, "head", "b")[column(table, "difference_cm")].high, -0.5);
  EXPECT_EQ(number(table, "head", "b", "percent_of_reference"), -25.0);
  EXPECT_EQ(number(table, "head", "b", "percent_of_method"), -100.0 / 3.0);
  EXPECT_EQ(row(table, "head", "b").back().text, "better");
  EXPECT_EQ(row(table, "head", "w").back().text, "worse");
  EXPECT_EQ(row(table, "head", "n").back().text, "no");
  EXPECT_EQ(row(table, "head", "-").back().text, "–");
  EXPECT_THAT(table.notes,
              testing::Contains(HasSubstr("% of nonlinear: 100 (method - nonlinear) / nonlinear")));
  EXPECT_THAT(table.notes, testing::Contains(HasSubstr("blocks of 1 s")));
}

TEST(AccuracyTables, BodiesHaveATableACondition) {
  ResultsSummary summary = hand_made_summary();
  BodyCell body;
  body.method = "mean";
  body.condition = "walking";
  body.alignment = "mean";
  body.mpjpe_m = 0.05;
  body.pck = {0.5, 0.75, 1.0};
  body.bones = 4;
  body.truth_jitter_m_s3 = 35.0;
  summary.bodies = {body};
  const Table table = accuracy_tables(summary).back();
  EXPECT_EQ(table.id, "bodies-walking");
  ASSERT_EQ(table.rows.size(), 1u);
  EXPECT_DOUBLE_EQ(table.rows[0][column(table, "mpjpe_cm")].number.value(), 5.0);
  EXPECT_DOUBLE_EQ(table.rows[0][column(table, "pck_10cm_percent")].number.value(), 75.0);
  EXPECT_EQ(printed(table.rows[0][column(table, "pa_mpjpe_cm")]), "–");
  EXPECT_THAT(table.notes, testing::Contains(HasSubstr("of 4 bones")));
}

TEST(AccuracyTables, NotesSayWhyThereIsNoInterval) {
  EXPECT_THAT(accuracy_tables(hand_made_summary()).at(0).notes,
              testing::Contains(HasSubstr("There are no intervals")));
}

// The activity is free text in campaign.json; the table's id becomes a file name and a LaTeX label.
TEST(AccuracyTables, AnyActivityGivesAnIdThatCanBeAFileName) {
  ResultsSummary summary = hand_made_summary();
  summary.conditions = {"../walk & run/50 %"};
  for (SummaryCell& cell : summary.cells) cell.condition = summary.conditions[0];
  const auto tables = accuracy_tables(summary);
  ASSERT_EQ(tables.size(), 1u);
  EXPECT_THAT(tables[0].id, testing::MatchesRegex("accuracy-[A-Za-z0-9._-]+-mean"));
  EXPECT_THAT(tables[0].title, HasSubstr("../walk & run/50 %"));
}

TEST(MethodsFigure, HasAPanelAJointTheLeastErrorOnTopAndThePaperAsRings) {
  const Figure figure = methods_figure(summary_with_best(), "walking", true);
  EXPECT_THAT(figure.y_names, ElementsAre("nonlinear", "mean"));
  EXPECT_THAT(figure.panels, ElementsAre("head", "shoulder", "elbow", "wrist", "average"));
  const FigureSeries &ours = figure.series.at(0), &paper = figure.series.at(1);
  EXPECT_NEAR(ours.points.at(0).x, 1.0, 1e-12);
  EXPECT_NEAR(ours.points.at(0).high, 1.5, 1e-12);
  EXPECT_TRUE(paper.hollow);
  EXPECT_EQ(paper.points.at(0).x, 5.3);
  EXPECT_THAT(figure.caption, AllOf(HasSubstr("Simulated"), HasSubstr("2 participants"), HasSubstr("95 %")));
  EXPECT_EQ(methods_figure(summary_with_best(), "walking", false).series.size(), 5u);
}

}  // namespace
}  // namespace trilat
