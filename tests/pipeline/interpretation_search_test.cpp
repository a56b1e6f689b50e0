// SPDX-License-Identifier: MIT
#include "pipeline/sweep/interpretation_search.h"

#include <gmock/gmock.h>

#include "tests/pipeline/swept_folders.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

// A printed table made from one reading.
PrintedTable1 table_of(const SweepSummary& s, std::size_t reading, bool axis_mean) {
  PrintedTable1 table;
  for (std::size_t t = 0; t < s.thresholds.size(); ++t) {
    PrintedTable1::Row row{s.thresholds[t], {}, {}, t == 0};
    for (std::size_t r = 0; r < s.ranges.size(); ++r) {
      const SweepCell& cell = s.cell(reading, t, r);
      row.error_cm.push_back(100.0 * (axis_mean ? cell.axis_mean_mae_m() : cell.mae_m));
      row.time_us.push_back(0.25 * cell.mean_iterations * (t == 0 ? 1.5 : 1.0));
    }
    table.rows.push_back(row);
  }
  table.ranges_cm.resize(s.ranges.size());
  return table;
}

TEST(InterpretationSearch, RanksTheReadingFirstThatTheTableIsMadeFrom) {
  const ScratchFolder folder;
  const SweepPlan plan = sweep_plan_of(kOneRig + R"(, "joints": ["centre", "volume"],
      "error_models": ["range_signed", "displacement"], "stops": ["objective"], "trials": 50)");
  const SweepSummary summary = sweep_into(folder / "results", plan).summary;
  EXPECT_FALSE(summary.search);
  for (std::size_t reading = 0; reading < summary.interpretations.size(); ++reading) {
    const SweepSearch search = search_interpretations(summary, table_of(summary, reading, true));
    EXPECT_EQ(search.tried, summary.interpretations.size());
    EXPECT_EQ(search.errors.ranked, 2 * search.tried);
    EXPECT_EQ(search.errors.best.at(0).interpretation, reading);
    EXPECT_EQ(search.errors.best[0].reported, "axis_mean");
    EXPECT_NEAR(search.errors.best[0].rms_log_ratio, 0.0, 1e-12);
    EXPECT_GT(search.errors.best[1].rms_log_ratio, 1e-6);
    EXPECT_EQ(search.times.best.at(0).interpretation, reading);
    EXPECT_NEAR(search.times.best[0].rms_log_ratio, 0.0, 1e-12);
    EXPECT_NEAR(search.times.best[0].us_per_iteration, 0.25, 1e-12);
    ASSERT_EQ(search.compromises.size(), 2u);
    EXPECT_NE(search.compromises[0].printed, search.compromises[0].corrected);
    EXPECT_GT(search.compromises[0].printed_iterations_factor.at(2), 100.0);
    EXPECT_LT(search.compromises[0].corrected_iterations_factor.at(2), 10.0);
    EXPECT_GE(search.compromises[0].printed_coverage, kMinSearchCoverage);
  }
}

TEST(InterpretationSearch, DoesNotRankAReadingThatFailsTooOften) {
  const ScratchFolder folder;
  const SweepPlan plan = sweep_plan_of(kOneRig + R"(, "gradients": ["corrected"], "trials": 100)");
  SweepSummary summary = sweep_into(folder / "results", plan).summary;
  const PrintedTable1 table = table_of(summary, 0, false);
  EXPECT_EQ(search_interpretations(summary, table).times.ranked, 2u);
  summary.cells[7].answered = 89;
  const SweepSearch search = search_interpretations(summary, table);
  EXPECT_EQ(search.times.ranked, 1u);
  EXPECT_EQ(search.tried, 2u);
  EXPECT_EQ(search.errors.best.at(0).interpretation, 1u);
}

TEST(InterpretationSearch, IsPartOfTheSummaryWhenAsked) {
  const ScratchFolder folder;
  const SweepPlan plan = sweep_plan_of(kOneRig + R"(, "trials": 20, "search": true)");
  sweep_into(folder / "results", plan);
  const auto search = read_results<SweepSummary>(folder / "results").search;
  ASSERT_TRUE(search);
  EXPECT_EQ(search->tried, 4u);
  EXPECT_LE(search->errors.best_rms, search->errors.median_rms);
}

}  // namespace
}  // namespace trilat
