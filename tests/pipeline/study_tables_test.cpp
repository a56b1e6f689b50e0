// SPDX-License-Identifier: MIT
// The tables and figures of sweeps and of clocks, each row against chosen numbers.
#include <gmock/gmock.h>

#include "pipeline/clocks/clocks_study.h"
#include "pipeline/sweep/sweep_tables.h"
#include "tests/pipeline/table_rows.h"

namespace trilat {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

std::vector<std::string> columns_of(const Table& table) {
  std::vector<std::string> names;
  for (const TableColumn& column : table.columns) names.push_back(column.name);
  return names;
}

// A sweep over thresholds (C) and ranges of errors (cm), with a number of each cell that follows from its
// place: an error of (10 + its number) cm, +- 1, of 100 trials that are all answered, in as many steps as its
// number + 1.
SweepSummary sweep_over(const std::vector<double>& thresholds,
                        const std::vector<std::array<double, 2>>& ranges_cm,
                        const std::vector<SweepSetting>& interpretations) {
  SweepSummary s;
  s.study = "table1";
  s.trials = 100;
  s.seed = 7;
  s.thresholds = thresholds.size();
  s.ranges = ranges_cm.size();
  for (SweepSetting setting : interpretations)
    for (const double threshold : thresholds)
      for (const auto& [low_cm, high_cm] : ranges_cm) {
        setting.threshold = threshold;
        setting.error_low_m = 0.01 * low_cm;
        setting.error_high_m = 0.01 * high_cm;
        const auto number = static_cast<double>(s.cells.size());
        const NumberKey key = setting.key();
        const double error_m = 0.1 + 0.01 * number;
        s.numbers.add({key.with(kSweptError), error_m, error_m - 0.01, error_m + 0.01, 100});
        s.numbers.add({key.with(kSweptSteps), number + 1.0, kNaN, kNaN, 100});
        s.numbers.add({key.with(kSweptAnswers), 1.0, kNaN, kNaN, 100});
        s.cells.push_back({setting});
      }
  return s;
}

SweepSetting setting_of(const char* gradient, const char* stop, const char* rig = "square") {
  SweepSetting setting;
  setting.rig = rig;
  setting.gradient = gradient;
  setting.stop = stop;
  return setting;
}

const std::vector<double> kPapersThresholds{1.0, 1e-2, 1e-4, 1e-6};
const std::vector<std::array<double, 2>> kPapersRanges_cm{{15, 30}, {5, 15}, {0, 5}};

SweepTimings timings_of(const SweepSummary& s, std::uint64_t problems) {
  SweepTimings timings;
  timings.problems = problems;
  for (std::size_t c = 0; c < s.cells.size(); ++c) timings.solve_us.push_back(0.5 * static_cast<double>(c));
  return timings;
}

TEST(SweepTables, Table1HasTheThreeWaysToReadThePaperSideBySide) {
  const SweepSummary s = sweep_over(kPapersThresholds, kPapersRanges_cm,
                                    {setting_of("printed", "printed"), setting_of("printed", "objective"),
                                     setting_of("corrected", "objective")});
  const std::vector<Table> tables = table1(s, timings_of(s, 10));
  ASSERT_EQ(tables.size(), 1u);
  const Table& table = tables[0];
  EXPECT_EQ(table.id, "table1-square");
  EXPECT_EQ(table.printed, "table1");
  EXPECT_EQ(table.about,
            "square, joint volume, error range_signed, C in cm2, start linear, damping none, gauss_newton; "
            "100 trials "
            "a cell, seed 7");
  const std::vector<std::string> rows = rows_of(table);
  ASSERT_EQ(rows.size(), 12u);
  // the cell of threshold t and range r is 3 t + r, those of the other ways 12 and 24 further
  EXPECT_EQ(rows[0],
            "15-30 | 1 | 21.4 | 10.00 | 22.00 | 34.00 | <0.1 | 0.00 | 6.00 | 12.00 | 1.0 | 13.0 | 25.0 | "
            "100.0 | 100.0");
  EXPECT_EQ(
      rows[3],
      "15-30 | 1e-06 | 13.7 | 19.00 | 31.00 | 43.00 | 1040 | 4.50 | 10.50 | 16.50 | 10.0 | 22.0 | 34.0 | "
      "100.0 | 100.0");
  EXPECT_EQ(
      rows[10],
      "0-5 | 0.0001 | 3.9 | 18.00 | 30.00 | 42.00 | 7 | 4.00 | 10.00 | 16.00 | 9.0 | 21.0 | 33.0 | 100.0 | "
      "100.0");
  EXPECT_THAT(rows_of(table1(s, timings_of(s, 0))[0])[3], HasSubstr("| 1040 | - | - | - | 10.0"));
  EXPECT_THAT(sweep_tables(s, timings_of(s, 10)).tables, SizeIs(2));
}

TEST(SweepTables, Table1NeedsThePapersGridAndBothGradients) {
  const auto tables = [](const SweepSummary& s) { return table1(s, timings_of(s, 0)).size(); };
  const std::vector<SweepSetting> both{setting_of("printed", "objective"),
                                       setting_of("corrected", "objective")};
  EXPECT_EQ(tables(sweep_over(kPapersThresholds, kPapersRanges_cm, both)), 1u);
  EXPECT_EQ(tables(sweep_over(kPapersThresholds, kPapersRanges_cm, {both[0]})), 0u);
  EXPECT_EQ(tables(sweep_over({1.0, 1e-2, 1e-4, 1e-5}, kPapersRanges_cm, both)), 0u);
  EXPECT_EQ(tables(sweep_over({1.0, 1e-2, 1e-4}, kPapersRanges_cm, both)), 0u);
  EXPECT_EQ(tables(sweep_over(kPapersThresholds, {{15, 30}, {5, 15}, {0, 6}}, both)), 0u);
  EXPECT_EQ(tables(sweep_over(kPapersThresholds, {{15, 30}, {5, 15}, {1, 5}}, both)), 0u);
  std::vector<SweepSetting> many;
  for (const char* rig : {"a", "b", "c", "d", "e", "f"})
    for (const char* gradient : {"printed", "corrected"})
      many.push_back(setting_of(gradient, "objective", rig));
  EXPECT_EQ(tables(sweep_over(kPapersThresholds, kPapersRanges_cm, many)), 6u);
  many.push_back(setting_of("printed", "objective", "g"));
  EXPECT_EQ(tables(sweep_over(kPapersThresholds, kPapersRanges_cm, many)), 0u);
}

TEST(SweepTables, EveryCellHasItsSettingAndItsNumbers) {
  SweepSummary s = sweep_over({1.0, 0.5}, {{5, 15}}, {setting_of("printed", "objective")});
  const NumberKey key = s.cells[1].key();
  const auto add = [&](const char* measure, const char* statistic, double value, std::uint64_t n = 100) {
    s.numbers.add({key.with({.measure = measure, .statistic = statistic}), value, kNaN, kNaN, n});
  };
  add("x", "mean_abs", 0.03);
  add("y", "mean_abs", 0.04);
  add("z", "mean_abs", 0.08);
  add("distance", "rms", 0.12);
  add("distance", "p95", 0.13);
  add("distance", "max", 0.14);
  add("start", "mean", 0.15);
  add("iterations", "median", 3);
  add("iterations", "p99", 4);
  add("iterations", "max", 5);
  add("status", "converged", 0.9, 90);
  add("status", "iteration_limit", 0.1, 10);
  StoredTables shown = sweep_tables(s, timings_of(s, 10));
  ASSERT_EQ(shown.tables.size(), 1u);  // it has not the paper's grid
  EXPECT_EQ(shown.tables[0].title, "Every cell of the sweep, simulated; 100 trials a cell, seed 7");
  EXPECT_THAT(columns_of(shown.tables[0]), Contains("a solve"));
  EXPECT_THAT(columns_of(sweep_tables(s, timings_of(s, 0)).tables[0]), Contains("a trial"));
  EXPECT_THAT(columns_of(shown.tables[0]), Contains("C in"));
  EXPECT_THAT(columns_of(shown.tables[0]), Contains("error model"));
  const std::string row = rows_of(shown.tables[0])[1];
  EXPECT_THAT(row, testing::StartsWith("square | "));
  EXPECT_THAT(row,
              testing::EndsWith(
                  " | 5 | 15 | 0.5 | 100 | 100 | 100.0 | 11.00 (10.00 to 12.00) | 5.00 | 12.00 | 13.00 | "
                  "14.00 | 15.00 | 2.00 | 3 | 4 | 5 | 0.500 | converged 90.0 %, iteration_limit "
                  "10.0 %"));
  EXPECT_EQ(shown.tables[0].shown, Table::Placement::detail);
  std::vector<double> thresholds;
  for (int k = 0; k < 200; ++k) thresholds.push_back(1.0 + k);
  s = sweep_over(thresholds, {{5, 15}}, {setting_of("printed", "objective")});
  EXPECT_EQ(sweep_tables(s, timings_of(s, 0)).tables.at(0).shown, Table::Placement::detail);
  thresholds.push_back(201.0);
  s = sweep_over(thresholds, {{5, 15}}, {setting_of("printed", "objective")});
  EXPECT_EQ(sweep_tables(s, timings_of(s, 0)).tables.at(0).shown, Table::Placement::file);
}

TEST(SweepTables, TheSentenceComparesTheLargestThresholdWithTheSmallest) {
  // two ranges: errors 10, 11, then 12 ... 15 cm, and steps 1, 2, then 3 ... 6
  SweepSummary s = sweep_over({1e-2, 1.0, 1e-4}, {{5, 15}, {0, 5}}, {setting_of("corrected", "objective")});
  EXPECT_THAT(
      sweep_tables(s, timings_of(s, 0)).findings,
      ElementsAre(
          "From C = 1 to C = 0.0001, the least and the most over interpretations and ranges of errors: "
          "1.50 to 1.67 times the steps with the corrected gradient, for 1.15 to 1.17 times the error "
          "(100 % answered at least)."));
  s = sweep_over({1.0}, {{5, 15}}, {setting_of("corrected", "objective")});
  EXPECT_THAT(sweep_tables(s, timings_of(s, 0)).findings,
              ElementsAre("One threshold, C = 1: there is nothing to compare."));
  s = sweep_over({1.0, 0.5}, {{5, 15}},
                 {setting_of("printed", "objective"), setting_of("corrected", "objective")});
  s.cells[3].start = "squared_ranges";  // of which there are no numbers
  const std::string text = sweep_tables(s, timings_of(s, 0)).findings[0];
  EXPECT_THAT(
      text,
      HasSubstr("some cells answer nothing with the corrected gradient; 2.00 to 2.00 times the steps with "
                "the printed gradient"));
  EXPECT_EQ(sweep_tables(s, timings_of(s, 0)).about,
            "Threshold sweep, **simulated**: 2 interpretations x 1 error range x 2 thresholds, 100 trials a "
            "cell.");
}

// 1 cm is Student's t of 99 degrees, 1.984217, times the standard error of 100 trials; of 5000 it is a root
// of 50 smaller, of 10 and 11 cm.
TEST(SweepTables, TheSpreadSaysHowExactFiveThousandTrialsAre) {
  SweepSummary s = sweep_over({1.0, 0.5}, {{5, 15}}, {setting_of("corrected", "objective")});
  EXPECT_THAT(sweep_tables(s, timings_of(s, 0)).errata.at("E18"),
              HasSubstr("has a standard error of 0.7 %, the median"));
  EXPECT_NEAR(100.0 * 1.0 / 1.984217 / std::sqrt(50.0) / 10.0, 0.7, 0.05);
  s.numbers = {};
  EXPECT_EQ(sweep_tables(s, timings_of(s, 0)).errata.at("E18"), "");
}

TEST(SweepFigures, HaveAPanelARangeAndALineAnInterpretation) {
  SweepSummary s = sweep_over({1.0, 1e-2}, {{5, 15}, {0, 5}},
                              {setting_of("printed", "objective"), setting_of("corrected", "objective")});
  for (std::size_t c = 0; c < s.cells.size(); ++c)
    for (const auto& [statistic, steps] : {std::pair{"median", 2.0}, {"p99", 9.0}})
      s.numbers.add({s.cells[c].key().with({.measure = "iterations", .statistic = statistic}), steps});
  std::vector<Figure> figures = sweep_figures(s, timings_of(s, 0));
  ASSERT_EQ(figures.size(), 3u);
  EXPECT_THAT(figures[0].panels, ElementsAre("5-15 cm", "0-5 cm"));
  EXPECT_EQ(figures[0].x_label, "stopping threshold C (cm2)");
  EXPECT_TRUE(figures[1].is_first);
  EXPECT_FALSE(figures[2].is_first);
  ASSERT_EQ(figures[0].series.size(), 4u);
  EXPECT_EQ(figures[0].series[3].name, "gradient corrected");
  EXPECT_EQ(figures[0].series[3].panel, 1u);
  ASSERT_EQ(figures[0].series[3].points.size(), 2u);  // cells 5 and 7, the smaller threshold first
  EXPECT_EQ(figures[0].series[3].points[0].x, 1e-2);
  EXPECT_NEAR(figures[0].series[3].points[0].y, 17.0, 1e-9);
  EXPECT_NEAR(figures[0].series[3].points[1].low, 14.0, 1e-9);
  EXPECT_NEAR(figures[0].series[3].points[1].high, 16.0, 1e-9);
  EXPECT_EQ(figures[1].series[0].points[0].y, 3.0);  // steps of cell 2
  EXPECT_EQ(figures[1].series[0].points[0].low, 2.0);
  EXPECT_EQ(figures[1].series[0].points[0].high, 9.0);
  EXPECT_TRUE(figures[1].log_y);
  EXPECT_NEAR(figures[2].series[0].points[0].y, 100.0, 1e-9);
  EXPECT_THAT(figures[0].caption, Not(HasSubstr("Rings")));
  figures = sweep_figures(s, timings_of(s, 10));
  ASSERT_EQ(figures.size(), 4u);
  EXPECT_EQ(figures[3].series[3].points[0].y, 3.5);
  for (SweepCell& cell : s.cells) cell.threshold_unit = cell.gradient == "printed" ? "cm2" : "m2";
  EXPECT_EQ(sweep_figures(s, timings_of(s, 0))[0].x_label, "stopping threshold C (as stated)");
}

TEST(SweepFigures, HaveThePapersNumbersBesideItsGridAndLeaveOutWhatIsTooMuch) {
  std::vector<SweepSetting> settings{setting_of("printed", "objective"),
                                     setting_of("corrected", "objective")};
  SweepSummary s = sweep_over(kPapersThresholds, kPapersRanges_cm, settings);
  const std::vector<Figure> figures = sweep_figures(s, timings_of(s, 10));
  ASSERT_EQ(figures[0].series.size(), 9u);
  EXPECT_EQ(figures[0].series[0].name, "the paper's");
  EXPECT_TRUE(figures[0].series[0].hollow);
  EXPECT_EQ(figures[0].series[0].points[1].y, 15.7);
  EXPECT_EQ(figures[0].series[2].panel, 1u);
  EXPECT_EQ(figures[1].series.size(), 6u);                    // it prints no steps
  EXPECT_TRUE(std::isnan(figures[3].series[0].points[0].y));  // "< 0.1"
  EXPECT_EQ(figures[3].series[0].points[2].y, 11.0);
  EXPECT_THAT(figures[0].caption, HasSubstr("Rings: what the paper prints."));
  std::vector<std::array<double, 2>> ranges_cm;
  for (int k = 0; k < 13; ++k) ranges_cm.push_back({1.0 * k, 2.0 * k + 1.0});
  s = sweep_over({1.0}, ranges_cm, {settings[0]});
  EXPECT_EQ(sweep_figures(s, timings_of(s, 0))[0].panels.size(), 12u);
  EXPECT_THAT(sweep_figures(s, timings_of(s, 0))[0].caption,
              HasSubstr(" Not drawn, but in sweep.csv: 1 curve."));
  settings.clear();
  for (const char* stop : {"printed", "objective", "step"})
    for (const char* gradient : {"printed", "corrected"}) settings.push_back(setting_of(gradient, stop));
  s = sweep_over({1.0}, {{0, 5}}, settings);
  EXPECT_EQ(sweep_figures(s, timings_of(s, 0))[0].series.size(), 6u);
  settings.push_back(setting_of("corrected", "step"));
  settings.back().damping = "lm";
  s = sweep_over({1.0}, {{0, 5}}, settings);
  EXPECT_EQ(sweep_figures(s, timings_of(s, 0))[0].series.size(), 6u);
  EXPECT_EQ(sweep_figures(s, timings_of(s, 0))[0].series[5].name,
            "gradient corrected, stop step, damping none");
}

// Every error as the paper prints it, as the mean distance (or over axes) and with these steps by threshold.
SweepSummary as_printed(double times, const std::array<double, 4>& steps, double answered = 1.0,
                        bool by_axis = false) {
  SweepSummary s = sweep_over(kPapersThresholds, kPapersRanges_cm, {setting_of("corrected", "objective")});
  const PrintedTable1 paper = printed_table1();
  s.numbers = {};
  for (std::size_t t = 0; t < 4; ++t)
    for (std::size_t r = 0; r < 3; ++r) {
      const NumberKey key = s.cell(0, t, r).key();
      const double error_m = 0.01 * times * paper.rows[t].error_cm[r];
      s.numbers.add({key.with(kSweptError), by_axis ? 10.0 * error_m : error_m});
      for (const char* axis : kAxisNames)
        s.numbers.add(
            {key.with({.measure = axis, .statistic = "mean_abs"}), by_axis ? error_m : 10.0 * error_m});
      s.numbers.add({key.with(kSweptSteps), steps[t]});
      s.numbers.add({key.with(kSweptAnswers), answered});
    }
  add_interpretations(s);
  return s;
}

TEST(SweepInterpretations, OfThoseThatAreNearThePaperSomeMakeACompromise) {
  const auto share = [](const SweepSummary& s, const char* statistic) {
    const NumberKey key{.measure = "interpretations", .statistic = statistic};
    return fmt::format("{} of {}", s.numbers.value(key), s.numbers.n(key));
  };
  const std::array<double, 4> doubled{1, 2, 4, 8};
  EXPECT_EQ(share(as_printed(1.0, doubled), "share"), "1 of 1");
  EXPECT_EQ(share(as_printed(1.0, doubled), "share_near"), "1 of 1");
  EXPECT_EQ(share(as_printed(1.0, {1, 2, 4, 7}), "share"), "0 of 1");  // less than twice the steps
  EXPECT_EQ(share(as_printed(1.9, doubled), "share_near"), "1 of 1");
  EXPECT_EQ(share(as_printed(2.1, doubled), "share_near"), "0 of 1");
  EXPECT_EQ(share(as_printed(0.51, doubled), "share_near"), "1 of 1");
  EXPECT_EQ(share(as_printed(0.49, doubled), "share_near"), "0 of 1");
  EXPECT_EQ(share(as_printed(1.0, doubled, 0.89), "share_near"), "0 of 1");
  EXPECT_EQ(share(as_printed(1.0, doubled, 0.9), "share_near"), "1 of 1");
  EXPECT_EQ(share(as_printed(1.0, doubled, 1.0, true), "share_near"), "1 of 1");
  SweepSummary other = sweep_over({1.0, 0.5}, {{5, 15}}, {setting_of("corrected", "objective")});
  const std::size_t before = other.numbers.all().size();
  add_interpretations(other);
  EXPECT_EQ(other.numbers.all().size(), before);
}

TEST(ClocksTables, StandBesideThePapersTableIV) {
  ClocksSummary s;
  s.study = "clocks";
  s.campaign = "lab";
  s.recordings = 1;
  s.late_s = 0.0333;
  s.failed = {"t2, k1: has no clock exchanges"};
  const auto add = [&](const NumberKey& key, double value, std::uint64_t n = 50) {
    s.numbers.add({key, value, kNaN, kNaN, n});
  };
  const NumberKey of_clock{.group = "k1", .take = "t1"};
  const auto fit = [&](const char* measure, const char* statistic, double value, std::uint64_t n) {
    add(of_clock.with({.measure = measure, .statistic = statistic}), value, n);
  };
  fit("clock_fit", "share_used", 0.8, 40);
  fit("clock_fit", "sigma", 0.0001, 40);
  fit("clock_fit", "bound", 0.0002, 40);
  fit("clock_fit", "bend", 0.0003, 40);
  fit("clock_fit", "share_within_bound", 0.99, 40);
  fit("latency", "median", 0.021, 30);
  fit("latency", "p99", 0.025, 30);
  fit("latency", "share_in_time", 1.0, 30);
  add(of_clock.with({.method = "none", .measure = "clock_error", .statistic = kShareBelow4ms}), 0.5, 90);
  const NumberKey live{.method = "corrected, causal", .measure = "clock_error"};
  double share = 0.5;
  for (const TimeRange& range : kTimeRanges) {
    add(live.with({.statistic = range.share}), share);
    share -= 0.08;
  }
  add(live.with({.statistic = kShareBelow4ms}), 0.92);
  add(live.with({.statistic = "share_of_units_below_4ms"}), 0.75);
  double second = 0.001;
  for (const char* statistic : {"median", "p95", "p99", "p999", "max"}) {
    add(live.with({.statistic = statistic}), second);
    second += 0.001;
  }
  add({.method = "as printed, for the server's clock", .measure = "clock_error", .statistic = "median"},
      12.0);
  const NumberKey queue{.condition = "as they come", .method = "corrected, causal", .measure = "queue"};
  add(queue.with({.statistic = "came"}), 1.0, 100);
  add(queue.with({.statistic = "untimed"}), 0.01, 1);
  add(queue.with({.statistic = "too_early"}), 0.02, 2);
  add(queue.with({.statistic = "too_late"}), 0.03, 3);
  add(queue.with({.statistic = "taken"}), 0.94, 94);
  StoredTables shown = clocks_tables(s);
  EXPECT_EQ(shown.title, "clocks on lab");
  EXPECT_EQ(shown.about, "Clocks of 1 recording, computers of 1 sensor, recorded.");
  EXPECT_THAT(
      shown.findings,
      ElementsAre(
          "A live system puts frames at their times to within 1.000 ms in the median and 3.000 ms in 99 "
          "% of 50 frames, against the fit of all exchanges."));
  EXPECT_THAT(shown.warnings, ElementsAre("Left out: t2, k1: has no clock exchanges"));
  EXPECT_EQ(shown.errata.at("E11"),
            "taken for the server's clock, a median error of 1.2e+04 ms; corrected, as a live "
            "system can, 1 ms");
  ASSERT_EQ(shown.tables.size(), 4u);
  EXPECT_EQ(shown.tables[0].title, "Table IV, clock errors: 1 recording, computers of 1 sensor (lab)");
  EXPECT_THAT(
      rows_of(shown.tables[0]),
      ElementsAre(
          "the paper's | 71998 | 99.64 | 0.36 | 0.00 | 0.00 | 0.00 | 0.00 | 100.00 | - | - | - | - | - | -",
          "corrected, causal | 50 | 50.00 | 42.00 | 34.00 | 26.00 | 18.00 | 10.00 | 92.00 | 75.00 | 1.000 "
          "| 2.000 | 3.000 | 4.000 | 5.000",
          "as printed, for the server's clock | 50 | - | - | - | - | - | - | - | - | 12000.000 | - | - | "
          "- | -"));
  EXPECT_THAT(rows_of(shown.tables[1]),
              ElementsAre("the paper's | the paper's | 18000 | - | - | 3 | 99.98",
                          "corrected, causal | as they come | 100 | 1 | 2 | 3 | 94.00"));
  EXPECT_THAT(shown.tables[1].title, HasSubstr("limit of the queue 33.3 ms"));
  EXPECT_THAT(rows_of(shown.tables[2]),
              ElementsAre("t1 | k1 | 40 | 80.0 | 0.100 | 0.200 | 0.300 | 99.0 | 90 | 21.0 | 25.0 | 100.0"));
  EXPECT_EQ(shown.tables[2].first_rows, 1u);
  EXPECT_EQ(shown.tables[2].printed, "");
  EXPECT_THAT(rows_of(shown.tables[3]),
              ElementsAre("depth image to joints | 17997 | 0.00 | 33.69 | 66.27 | 0.04"));
  EXPECT_EQ(shown.tables[3].printed, "table4");
  EXPECT_EQ(shown.tables[1].shown, Table::Placement::first);
  EXPECT_EQ(shown.tables[2].shown, Table::Placement::detail);
  s.simulated = true;
  s.recordings = 2;
  for (int k = 0; k < 10; ++k)
    add({.group = fmt::format("s{}", k), .measure = "clock_fit", .statistic = "share_used", .take = "t2"},
        0.5);
  shown = clocks_tables(s);
  EXPECT_EQ(shown.about, "Clocks of 2 recordings, computers of 11 sensors, **simulated**.");
  EXPECT_THAT(shown.findings[0], HasSubstr("Simulated: a live system"));
  EXPECT_EQ(shown.tables[2].first_rows, 8u);
  s.study = "lab";
  s.numbers = {};
  EXPECT_EQ(clocks_tables(s).title, "lab");
  EXPECT_THAT(clocks_tables(s).findings, IsEmpty());
}

}  // namespace
}  // namespace trilat
