// SPDX-License-Identifier: MIT
#include <cmath>

#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "datasets/paper/printed_tables.h"
#include "reports/figures/figures.h"
#include "reports/render/render.h"
#include "reports/tables/tables.h"
#include "reports/write_report.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

ClockErrorRow clock_row(const std::string& method, std::uint64_t good, std::uint64_t bad) {
  ClockErrorRow row;
  row.network = "lan";
  row.method = method;
  row.asked = row.error.n = good + bad;
  row.error.bins = {good, bad, 0, 0, 0, 0};
  row.error.median_s = 0.0015;
  row.below_2ms = static_cast<double>(good) / static_cast<double>(good + bad);
  row.below_2ms_low = row.below_2ms - 0.001;
  row.below_2ms_high = row.below_2ms;
  row.units = {{good + bad, good + bad, good, good + bad}, {}, {}, {}, {}, {}, {}, {}};
  return row;
}

RecordingSummary summary_of(std::uint64_t good, std::uint64_t bad) {
  RecordingSummary s{"table4", 5, 100, 4, 2, {}, {{"lan", 1e-5, 2e-4, 1.0, 0.25}}, 1.0 / 30.0, {}};
  s.clocks = {clock_row("corrected", good, bad), clock_row("as printed, on the client's clock", 950, 50)};
  s.queues = {{"lan", "corrected", "as they come", {1000, 1, 2, 7, 990}, 0.98, 1.0}};
  return s;
}

StageTimings timings_of(std::uint64_t late) {
  TimeSpread time;
  time.n = 1000;
  time.bins = {900, 50, 25, 15, 10 - late, late};
  time.median_s = 28e-6;
  TimeSpread later = time;
  later.bins = {0, 0, 950, 0, 0, 50};
  return {"table4",
          "a processor",
          {{"trilateration", "nonlinear", time},
           {kDepthToJoints, "linear", time},
           {kDepthToJoints, "nonlinear", later}}};
}

double cell_number(const Table& table, std::size_t row, const std::string& key) {
  for (std::size_t c = 0; c < table.columns.size(); ++c)
    if (table.columns[c].key == key) return table.rows.at(row).at(c).number.value();
  throw std::out_of_range(key);
}

TEST(Table4, SetsThePapersClockErrorsBesideOurs) {
  const Table table = table4_clocks(summary_of(998, 2));
  EXPECT_THAT(table.title, HasSubstr("simulated"));
  EXPECT_NEAR(cell_number(table, 0, "below_2ms_percent"), 100.0 * 71740 / 71998, 1e-9);
  EXPECT_NEAR(cell_number(table, 0, "from_2_to_4ms_percent"), 100.0 * 258 / 71998, 1e-9);
  EXPECT_EQ(cell_number(table, 0, "from_33ms_percent"), 0.0);
  EXPECT_NEAR(cell_number(table, 1, "below_2ms_percent"), 99.8, 1e-9);
  EXPECT_NEAR(cell_number(table, 1, "median_ms"), 1.5, 1e-9);
}

TEST(Table4, SaysHowManyClockErrorsAreBelow4msAndOfHowManyRunsAllAre) {
  RecordingSummary s = summary_of(990, 6);
  ClockErrorRow& row = s.clocks[0];
  row.error.bins[5] = 4;
  row.error.n = 1000;
  row.units = {{500, 500, 495, 500}, {500, 500, 495, 496}, {100, 0, 0, 0}};
  const Table table = table4_clocks(s);
  EXPECT_NEAR(cell_number(table, 0, "below_4ms_percent"), 100.0, 1e-9);  // the paper's
  EXPECT_NEAR(cell_number(table, 1, "below_4ms_percent"), 99.6, 1e-9);
  EXPECT_NEAR(cell_number(table, 1, "units_below_4ms_percent"), 50.0, 1e-9);  // one gave no answer
}

TEST(Table4, SaysHowManyFramesAreTakenAndProcessedInTimeBesideThePapers) {
  const Table table = table4_queue(summary_of(998, 2), timings_of(0));
  EXPECT_THAT(table.title, testing::AllOf(HasSubstr("simulated"), HasSubstr("33.3 ms")));
  EXPECT_EQ(cell_number(table, 0, "too_late"), 3.0);
  EXPECT_NEAR(cell_number(table, 0, "taken_percent"), 100.0 * 17997 / 18000, 1e-9);
  EXPECT_NEAR(cell_number(table, 0, "processed_percent"), 100.0 * 17990 / 17997, 1e-9);
  EXPECT_EQ(cell_number(table, 0, "real_time_percent"), 99.94);
  EXPECT_EQ(cell_number(table, 1, "too_early"), 2.0);
  EXPECT_NEAR(cell_number(table, 1, "taken_percent"), 99.0, 1e-9);
  EXPECT_NEAR(table.rows[1][7].low, 98.0, 1e-9);
  EXPECT_NEAR(cell_number(table, 1, "processed_percent"), 95.0, 1e-9);  // by the slowest method
  EXPECT_NEAR(cell_number(table, 1, "real_time_percent"), 99.0 * 0.95, 1e-9);
  EXPECT_TRUE(
      std::isnan(cell_number(table4_queue(summary_of(998, 2), std::nullopt), 1, "real_time_percent")));
}

TEST(Table4, CountsTheThreeShortestRangesAsThePapersShortest) {
  const Table table = table4_processing(timings_of(4));
  EXPECT_EQ(cell_number(table, 0, "below_11ms_percent"), 0.0);
  EXPECT_NEAR(cell_number(table, 0, "from_22_to_33ms_percent"), 100.0 * 11926 / 17997, 1e-9);
  EXPECT_NEAR(cell_number(table, 1, "below_11ms_percent"), 97.5, 1e-9);
  EXPECT_NEAR(cell_number(table, 1, "from_33ms_percent"), 0.4, 1e-9);
  EXPECT_NEAR(cell_number(table, 1, "median_us"), 28.0, 1e-9);
}

TEST(Table4, PartsThatWereNotRunGiveNoTable) {
  EXPECT_EQ(table4(summary_of(1, 0), std::nullopt).size(), 3u);
  EXPECT_EQ(table4(summary_of(1, 0), timings_of(0)).size(), 4u);
  EXPECT_TRUE(table4({}, std::nullopt).empty());
}

TEST(Table4, IsAChapterOfTheReportWithOrWithoutTimes) {
  const ScratchFolder folder;
  write_results(folder.path(), summary_of(998, 2));
  EXPECT_EQ(write_report({folder.path()}, folder / "a").tables, 3u);
  EXPECT_THAT(read_file(folder / "a/report.md"), HasSubstr("99.80"));
  write_beside(folder.path(), timings_of(1));
  EXPECT_EQ(write_report({folder.path()}, folder / "b").tables, 4u);
}

}  // namespace
}  // namespace trilat
