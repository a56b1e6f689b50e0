// SPDX-License-Identifier: MIT
#include "datasets/results/studies/sweep_summary.h"

#include <cmath>

#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "datasets/results/results_file.h"
#include "datasets/results/studies/sweep_timings.h"
#include "datasets/results/summary.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

SweepCell full_cell(std::size_t threshold) {
  SweepCell cell;
  cell.threshold = threshold;
  cell.asked = 10;
  cell.answered = 9;
  cell.statuses = {{"converged", 9}, {"rank_deficient", 1}};
  cell.mae_m = 0.1 + 0.2;  // no short decimal
  cell.axis_mae_m = {0.1, 0.2, 1.0 / 3.0};
  cell.p99_iterations = 7.0;
  cell.digits_trials = 4;
  cell.min_digits = 3.25;
  return cell;
}

SweepSummary two_cells() {
  SweepSummary s;
  s.study = "sweep";
  s.seed = 7;
  s.trials = 10;
  s.thresholds = {1.0, 1e-2};
  s.ranges = {{0.15, 0.3}};
  s.interpretations = {{"flat/centre",
                        "flat",
                        {{0, 1, 2}, {3, 4, 5}, {6, 7, 8}},
                        "centre",
                        "gaussian",
                        "cm2",
                        "printed",
                        "gauss_newton",
                        "objective",
                        "none",
                        "linear"}};
  s.cells = {full_cell(0), full_cell(1)};
  s.cells[1].mae_m = SweepCell::kNone;
  return s;
}

TEST(SweepSummary, WhatIsWrittenIsReadBackAndNaNStaysNaN) {
  const ScratchFolder folder;
  SweepSummary written = two_cells();
  written.search = SweepSearch{1, {{{0, "axis_mean", 0.25, 1.5, 0.0}}, 2, 0.25, 0.5, 0.75}, {}, {}};
  written.search->compromises = {{"errors", 0, 0, {900.0}, {2.0}, {0.4}, {0.5}, 1.0, 0.75}};
  write_sweep_summary(folder.path(), written);
  const SweepSummary read = read_sweep_summary(folder.path());
  EXPECT_TRUE(read.simulated);
  EXPECT_EQ(read.thresholds, written.thresholds);
  EXPECT_EQ(read.ranges.at(0).high_m, 0.3);
  EXPECT_EQ(read.interpretations.at(0).sensors_m, written.interpretations[0].sensors_m);
  EXPECT_EQ(read.interpretations[0].start, "linear");
  EXPECT_EQ(read.cell(0, 0, 0).mae_m, 0.1 + 0.2);
  EXPECT_EQ(read.cell(0, 0, 0).axis_mae_m, written.cells[0].axis_mae_m);
  EXPECT_EQ(read.cell(0, 0, 0).statuses, written.cells[0].statuses);
  EXPECT_TRUE(std::isnan(read.cell(0, 1, 0).mae_m));
  EXPECT_EQ(read.cell(0, 1, 0).min_digits, 3.25);
  EXPECT_EQ(read.search->errors.best.at(0).reported, "axis_mean");
  EXPECT_EQ(read.search->errors.median_rms, 0.5);
  EXPECT_EQ(read.search->compromises.at(0).printed_iterations_factor, std::vector<double>{900.0});
  EXPECT_EQ(read.search->compromises[0].corrected_coverage, 0.75);
  const std::string first = read_file(folder / "summary.json");
  write_sweep_summary(folder.path(), read);
  EXPECT_EQ(read_file(folder / "summary.json"), first);
}

TEST(SweepSummary, TheTwoKindsOfResultsAreToldApart) {
  const ScratchFolder folder;
  write_sweep_summary(folder.path(), two_cells());
  EXPECT_EQ(results_kind(folder.path()), StudyKind::threshold_sweep);
  EXPECT_THAT(message_of([&] { read_summary(folder.path()); }),
              HasSubstr("/kind: is \"threshold_sweep\"; results of kind \"accuracy\" are needed here"));
  write_summary(folder.path(), ResultsSummary{});
  EXPECT_EQ(results_kind(folder.path()), StudyKind::accuracy);
  EXPECT_THAT(message_of([&] { read_sweep_summary(folder.path()); }), HasSubstr("/kind: is \"accuracy\""));
}

TEST(SweepSummary, CellsThatDoNotFitItsListsAreRefused) {
  const ScratchFolder folder;
  SweepSummary summary = two_cells();
  std::swap(summary.cells[0], summary.cells[1]);
  write_sweep_summary(folder.path(), summary);
  EXPECT_THAT(message_of([&] { read_sweep_summary(folder.path()); }),
              HasSubstr("/cells: must hold one cell"));
  summary.cells.pop_back();
  write_sweep_summary(folder.path(), summary);
  EXPECT_THAT(message_of([&] { read_sweep_summary(folder.path()); }),
              HasSubstr("/cells: must hold one cell"));
}

TEST(SweepSummary, ACompromiseHasAFactorForEachRangeOrIsRefused) {
  const ScratchFolder folder;
  SweepSummary summary = two_cells();
  summary.search = SweepSearch{1, {}, {}, {}};
  for (const std::vector<double>& factors : {std::vector<double>{}, {2.0, 3.0}}) {
    summary.search->compromises = {{"errors", 0, 0, {900.0}, factors, {0.4}, {0.5}, 1.0, 0.75}};
    write_sweep_summary(folder.path(), summary);
    EXPECT_THAT(message_of([&] { read_sweep_summary(folder.path()); }),
                HasSubstr("/search/compromises/0/corrected_iterations_factor: must be an array of a number"));
  }
}

TEST(SweepTimings, AreAFileOfTheirOwnThatNeedNotBeThere) {
  const ScratchFolder folder;
  EXPECT_FALSE(read_sweep_timings(folder.path()));
  write_sweep_timings(folder.path(), {"sweep", "a processor", 500, 7, {{0, 1, 2, 310.5, 300.0, 40.0, 39.5}}});
  const auto read = read_sweep_timings(folder.path());
  ASSERT_TRUE(read);
  EXPECT_EQ(read->repeats, 7u);
  EXPECT_EQ(read->cells.at(0).scalar_median_ns, 310.5);
  EXPECT_EQ(read->cells[0].range, 2u);
}

}  // namespace
}  // namespace trilat
