// SPDX-License-Identifier: MIT
#include <cmath>

#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "datasets/paper/printed_tables.h"
#include "datasets/results/summary.h"
#include "reports/figures/figures.h"
#include "reports/render/render.h"
#include "reports/tables/tables.h"
#include "reports/write_report.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

SweepInterpretation reading(const std::string& gradient, const std::string& stop) {
  SweepInterpretation i;
  i.id = "tall/volume/range_signed/cm2/" + gradient + "/" + stop;
  i.rig = "tall";
  i.joint = "volume";
  i.error_model = "range_signed";
  i.threshold_unit = "cm2";
  i.gradient = gradient;
  i.curvature = "gauss_newton";
  i.stop = stop;
  i.damping = "none";
  i.start = "linear";
  return i;
}

// The paper's grid; errors and steps tell reading, threshold and range apart.
SweepSummary hand_made_sweep() {
  SweepSummary s;
  s.study = "by hand";
  s.seed = 7;
  s.trials = 100;
  const PrintedTable1 paper = printed_table1();
  for (const auto& row : paper.rows) s.thresholds.push_back(row.threshold);
  for (const auto& range : paper.ranges_cm) s.ranges.push_back({range[0] / 100.0, range[1] / 100.0});
  s.interpretations = {reading("printed", "printed"), reading("printed", "objective"),
                       reading("corrected", "objective")};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t t = 0; t < 4; ++t)
      for (std::size_t r = 0; r < 3; ++r) {
        SweepCell c;
        c.interpretation = i;
        c.threshold = t;
        c.range = r;
        c.asked = 100;
        c.answered = 98;
        c.statuses = {{"converged", 98}, {"iteration_limit", 2}};
        c.mae_m = 0.01 * static_cast<double>(100 * i + 10 * t + r);
        c.mean_iterations = static_cast<double>(1000 * i + 10 * t + r);
        s.cells.push_back(c);
      }
  return s;
}

SweepTimings hand_made_timings() {
  SweepTimings timings;
  timings.study = "by hand";
  timings.repeats = 3;
  timings.problems = 10;
  timings.cells.push_back({2, 3, 1, 1500.0, 1400.0, 150.0, 140.0});
  return timings;
}

std::size_t sweep_column(const Table& table, const std::string& key) {
  for (std::size_t c = 0; c < table.columns.size(); ++c)
    if (table.columns[c].key == key) return c;
  ADD_FAILURE() << "no column " << key;
  return 0;
}

TEST(Table1, PutsEveryReadingInItsColumnBesideThePapersNumber) {
  const std::vector<Table> tables = table1(hand_made_sweep(), hand_made_timings());
  ASSERT_THAT(tables, SizeIs(1));
  const Table& table = tables[0];
  EXPECT_THAT(table.title, HasSubstr("simulated"));
  ASSERT_THAT(table.rows, SizeIs(12));
  const auto& row = table.rows[7];  // second range, smallest threshold
  const auto number = [&](const char* key) { return row[sweep_column(table, key)].number.value(); };
  EXPECT_EQ(row[sweep_column(table, "range_cm")].text, "5-15");
  EXPECT_DOUBLE_EQ(number("threshold"), 1e-6);
  EXPECT_DOUBLE_EQ(number("paper_error_cm"), 6.6);
  EXPECT_DOUBLE_EQ(number("paper_time_us"), 783);
  EXPECT_DOUBLE_EQ(number("as_printed_error_cm"), 31);
  EXPECT_DOUBLE_EQ(number("printed_error_cm"), 131);
  EXPECT_DOUBLE_EQ(number("corrected_error_cm"), 231);
  EXPECT_DOUBLE_EQ(number("as_printed_iterations"), 31);
  EXPECT_DOUBLE_EQ(number("corrected_iterations"), 2031);
  EXPECT_DOUBLE_EQ(number("corrected_time_us"), 1.5);
  EXPECT_TRUE(std::isnan(number("printed_time_us")));
  EXPECT_DOUBLE_EQ(number("corrected_answered_percent"), 98);
  EXPECT_EQ(table.rows[0][sweep_column(table, "paper_time_us")].text, "<0.1");
  for (const auto& values : table.rows) EXPECT_EQ(values.size(), table.columns.size());
}

TEST(Table1, IsOnlyMadeOfThePapersGrid) {
  SweepSummary s = hand_made_sweep();
  s.thresholds[1] = 0.02;
  EXPECT_THAT(table1(s, {}), IsEmpty());
}

// The reading that leads the search is shown in the metric that it fits in.
TEST(Table1, ShowsTheMeanOverTheAxesWhereTheSearchFoundThatMetric) {
  SweepSummary s = hand_made_sweep();
  for (SweepCell& cell : s.cells) cell.axis_mae_m = {0.01, 0.02, 0.06};
  s.search.emplace();
  s.search->errors.best = {{1, "axis_mean", 0.1, 1.2, 0.0}};
  const Table table = table1(s, {}).at(0);
  EXPECT_DOUBLE_EQ(table.rows[0][sweep_column(table, "printed_error_cm")].number.value(), 3.0);
  EXPECT_THAT(table.notes[0], HasSubstr("mean over the three axes"));
}

TEST(SweepTables, HoldEveryCellWithEachOfItsSettings) {
  const SweepSummary s = hand_made_sweep();
  const Table table = sweep_table(s, hand_made_timings());
  ASSERT_EQ(table.rows.size(), s.cells.size());
  for (const auto& values : table.rows) ASSERT_EQ(values.size(), table.columns.size());
  EXPECT_THAT(table.title, HasSubstr("simulated"));
  const std::string text = markdown_of(table);
  for (const char* part : {"converged 98.0 %, iteration_limit 2.0 %", "1e-06", "1.500"})
    EXPECT_THAT(text, HasSubstr(part));
  EXPECT_THAT(csv_of(table),
              HasSubstr("gradient,curvature,stop,damping,start,range_low_cm,range_high_cm,threshold"));
}

SweepSearch hand_made_search() {
  SweepSearch search;
  search.tried = 3;
  search.errors.best = {{1, "distance", std::log(1.25), 2.0, 0.0}};
  search.errors.ranked = 6;
  search.errors.best_rms = std::log(1.25);
  search.errors.median_rms = std::log(2.0);
  search.errors.worst_rms = std::log(9.0);
  search.times = search.errors;
  search.times.best[0].us_per_iteration = 0.5;
  search.compromises = {
      {"times", 1, 2, {300, 400, 950}, {2, 2.5, 3}, {0.5, 0.6, 0.7}, {0.9, 0.95, 1}, 1.0, 0.62}};
  return search;
}

TEST(SearchTables, SayHowManyWereTriedAndWhetherTheCompromiseSurvives) {
  SweepSummary s = hand_made_sweep();
  EXPECT_THAT(search_tables(s), IsEmpty());
  s.search = hand_made_search();
  const std::vector<Table> tables = search_tables(s);
  ASSERT_THAT(tables, SizeIs(3));
  for (const Table& table : tables)
    for (const auto& values : table.rows) EXPECT_EQ(values.size(), table.columns.size());
  EXPECT_THAT(tables[0].title, HasSubstr("3 tried"));
  EXPECT_THAT(tables[0].notes[0], HasSubstr("best 1.25, median 2.00, worst 9.00"));
  const auto sentences = search_sentences(s);
  ASSERT_THAT(sentences, SizeIs(3));
  EXPECT_THAT(sentences[2], HasSubstr("300 to 950 times"));
  EXPECT_THAT(sentences[2], HasSubstr("no verdict, because only 62 % of the trials are answered"));
  s.search->compromises[0].corrected_coverage = 0.95;
  EXPECT_THAT(search_sentences(s)[2], HasSubstr("does not survive"));
  s.search->compromises[0].corrected_iterations_factor = {2, 2.5, 300};
  EXPECT_THAT(search_sentences(s)[2], HasSubstr("the compromise survives"));
  s.search->compromises[0].printed_error_factor = {1.0, 1.0, 0.99};
  EXPECT_THAT(search_sentences(s)[2], HasSubstr("buy nothing"));
  s.search->compromises[0].printed_error_factor[0] = kNoNumber;
  EXPECT_THAT(search_sentences(s), SizeIs(2));
}

TEST(WriteReport, TellsASweepFromAnAccuracyStudy) {
  const ScratchFolder folder;
  SweepSummary s = hand_made_sweep();
  s.search = hand_made_search();
  std::filesystem::create_directories(folder / "sweep");
  write_results(folder / "sweep", s);
  const ReportFiles files = write_report({folder / "sweep"}, folder / "report");
  EXPECT_EQ(files.tables, 5u);  // the search's, Table I, and every cell
  const std::string text = read_file(folder / "report/report.md");
  EXPECT_THAT(text, HasSubstr("Threshold sweep, **simulated**"));
  EXPECT_THAT(text, HasSubstr("Of 3 readings tried"));
}

TEST(SweepFigures, HaveAPanelARangeAndThePapersErrorsBesideOurs) {
  const std::vector<Figure> figures = sweep_figures(hand_made_sweep(), std::nullopt);
  ASSERT_EQ(figures.size(), 3u);  // nothing was timed
  const Figure &errors = figures[0], &steps = figures[1];
  EXPECT_THAT(errors.panels, ElementsAre("15-30 cm", "5-15 cm", "0-5 cm"));
  ASSERT_EQ(errors.series.size(), 12u);  // three readings and the paper's
  EXPECT_TRUE(errors.series[0].hollow);
  EXPECT_EQ(errors.series[0].points[1].x, 1e-2);
  EXPECT_EQ(errors.series[0].points[1].y, 15.7);  // printed for 15 to 30 cm
  EXPECT_EQ(steps.series.size(), 9u);
  EXPECT_THAT(errors.title, HasSubstr("simulated"));
  EXPECT_THAT(errors.caption, HasSubstr("trials a point"));
}

TEST(SweepFigures, AnyGridHasThem) {
  SweepSummary s = hand_made_sweep();
  s.thresholds[1] = 0.02;
  const std::vector<Figure> figures = sweep_figures(s, std::nullopt);
  ASSERT_EQ(figures.size(), 3u);
  EXPECT_EQ(figures[0].series.size(), 9u);  // without the paper's
}

}  // namespace
}  // namespace trilat
