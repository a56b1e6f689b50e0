// SPDX-License-Identifier: MIT
// The summaries of all kinds but accuracy; what all of them share is in described_test.cpp.
#include <cmath>
#include <functional>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/paper/printed_tables.h"
#include "datasets/results/results_file.h"
#include "datasets/results/studies/budget_summary.h"
#include "datasets/results/studies/calibration_summary.h"
#include "datasets/results/studies/recording_summary.h"
#include "datasets/results/studies/sensitivity_summary.h"
#include "datasets/results/studies/sweep_summary.h"
#include "datasets/results/studies/timings.h"
#include "datasets/results/studies/tracking_summary.h"
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

CalibrationSummary full_calibration() {
  CalibrationSummary s;
  s.study = "calibration";
  s.seed = 7;
  s.samples = 3;
  s.units = 2;
  s.frames = 5;
  s.ball_radius_m = 0.075;
  s.positions = 50;
  const ErrorSpread spread{4, 3, 0.1 + 0.2, 1.0 / 3.0, 0.3, 0.4, 0.5, 0.25, 0.35};
  s.wand = {{"as printed", "free", spread, {}, {}, {{"found", 3}, {"no_wand", 1}}},
            {"ours", "room", {}, spread, spread, {}, {4, 2, 0.007}}};
  s.wand_samples = {{0, 1, 1.5, 0.25, 0.012, 0.004}, {1, 0, 2.5, 0.5, kNoNumber, kNoNumber}};
  s.distortion = {{2.0,
                   1000,
                   1,
                   -0.013,
                   {1000, 0},
                   {0.01, kNoNumber},
                   {0.001, kNoNumber},
                   {0.2, kNoNumber},
                   {0.003, 0.0}}};
  s.rigs = {{"wand", 6, 1, spread, 0.001, 0.002, 0.875, 0.95, 0.9, kNoNumber, 1.1, 0.9, 6.5, 1.02}};
  return s;
}

TimeSpread small_spread() {
  TimeSpread spread;
  spread.n = 6;
  spread.bins = {1, 2, 0, 0, 0, 3};
  spread.median_s = 1.0 / 3.0;
  spread.max_s = 0.5;
  return spread;
}

RecordingSummary full_recording() {
  RecordingSummary s{"table4", 18'000'000'000'000'000'000u, 6, 2, 1, {}, {}, 0.02, {}};
  s.clocks = {{"lan", "corrected", 7, small_spread(), 1.0 / 6.0, 0.1, 0.2, {{3, 2, 0, 1}, {4, 4, 1, 2}}},
              {"lan", "none", 6, {}, kNoNumber, kNoNumber, kNoNumber, {{6, 0, 0, 0}, {}}}};
  s.fits = {{"lan", 1e-5, 2e-4, 1.0, 0.25}, {"cut"}};
  s.queues = {{"lan", "corrected", "as they come", {10, 1, 2, 3, 4}, 0.3, kNoNumber}};
  return s;
}

BudgetSummary small_budget() {
  BudgetSummary s;
  s.study = "budget";
  s.campaign = "two persons";
  s.seed = 18'000'000'000'000'000'000u;
  s.participants = 2;
  s.calibration_sigma_m = 0.005;
  s.calibration_sigma_rad = 0.1 + 0.2;
  s.sources = {"none", "jitter", "all"};
  s.descriptions = {"nothing", "noise", "all"};
  s.rows = {{"none", "mean", "walking", "wrist", "none", 60, 1.0 / 3.0, 0.001},
            {"jitter", "mean", "walking", "wrist", "none", 0, kNoNumber, kNoNumber},
            {"all", "mean", "walking", "wrist", "none", 60, 0.02, 0.01}};
  return s;
}

SensitivitySummary full_sensitivity() {
  SensitivitySummary s;
  s.study = "map";
  s.alignments = {"rigid"};
  s.parts = {{"calibrated", "bias", 0.0, 0.02}};
  s.methods = {"mean", "linear"};
  s.factors = {{"bias", "m", "/body_tracker/bias_sigma_m", {}, 0.01, 0.1, true, false}};
  s.slices = {{"slice", "bias", "bias", 3, {"claim"}}};
  s.claims = {{"claim", "linear", {"mean"}, 1.0, 2, {0.5, 0.4, 0.6}}};
  s.claims[0].factors = {{"bias", {0.1, kNoNumber, 0.2}, {}, {}, {{0.5, {1.0, 0.9, 1.1}, {}}}}};
  s.claims[0].side_by_side = {{"rigid", "calibrated", 7, {0.5, 0.4, 0.6}, {-1.0, -2.0, 0.5}, 3.0, {}}};
  s.best_share = {{0.5, 0.25, 0.75}, {}};
  s.points = {{"space", 0, {0.5}, {0.01, 0.02, kNoNumber, 0.03}, {1.0, 0.5}, ""}};
  return s;
}

// What is read and written again is the same text, and one thing changed in it is refused with its place.
template <class Summary>
class SummaryFile {
 public:
  explicit SummaryFile(const Summary& summary) {
    write_results(folder_.path(), summary);
    text_ = read_file(folder_ / "summary.json");
  }
  std::string again() {
    write_results(folder_.path(), read_results<Summary>(folder_.path()));
    return read_file(folder_ / "summary.json");
  }
  const std::string& text() const { return text_; }
  std::string refusal(const char* pointer, const Json& value) {
    Json json = parse_json(text_, "summary.json");
    json[Json::json_pointer(pointer)] = value;
    write_file(folder_ / "summary.json", json_text(json, -1));
    return message_of([&] { read_results<Summary>(folder_.path()); });
  }

 private:
  ScratchFolder folder_;
  std::string text_;
};

TEST(SweepSummary, IsReadAsItWasWrittenAndFitsItsLists) {
  SweepSummary summary = two_cells();
  summary.search = SweepSearch{1, {{{0, "axis_mean", 0.25, 1.5, 0.0}}, 2, 0.25, 0.5, 0.75}, {}, {}};
  summary.search->compromises = {{"errors", 0, 0, {900.0}, {2.0}, {0.4}, {0.5}, 1.0, 0.75}};
  SummaryFile file(summary);
  EXPECT_EQ(file.again(), file.text());
  EXPECT_THAT(file.refusal("/cells/1/threshold", 0), HasSubstr("/cells: must hold one cell"));
  EXPECT_THAT(file.refusal("/ranges", Json::array()), HasSubstr("/cells: must hold one cell"));
  EXPECT_THAT(file.refusal("/search/errors/best/0/interpretation", 1),
              HasSubstr("/search: has the number of no interpretation"));
  EXPECT_THAT(file.refusal("/search/compromises/0/corrected", 1),
              HasSubstr("/search: has the number of no interpretation"));
  for (const Json& factors : {Json::array(), Json::array({2.0, 3.0})})
    EXPECT_THAT(file.refusal("/search/compromises/0/corrected_iterations_factor", factors),
                HasSubstr("/search: must have a factor for each range"));
}

TEST(CalibrationSummary, IsReadAsItWasWrittenAndFitsItsLists) {
  SummaryFile file(full_calibration());
  EXPECT_EQ(file.again(), file.text());
  EXPECT_THAT(file.refusal("/wand_samples/1/0", 2),
              HasSubstr("/wand_samples: must be of rows that are there"));
  for (const char* curve : {"depth_error_m", "depth_residual_m", "printed_error_m", "lens_error_m"})
    EXPECT_THAT(file.refusal((std::string("/distortion/0/") + curve).c_str(), {1.0}),
                HasSubstr("/distortion/0/valid: must be as long as the curves"))
        << curve;
}

TEST(RecordingSummary, IsReadAsItWasWrittenAndFitsItsLists) {
  SummaryFile file(full_recording());
  EXPECT_EQ(file.again(), file.text());
  EXPECT_THAT(file.refusal("/runs", 3), HasSubstr("/clocks: must have units of each run and sensor"));
}

TEST(BudgetSummary, IsReadAsItWasWrittenAndFitsItsLists) {
  SummaryFile file(small_budget());
  EXPECT_EQ(file.again(), file.text());
  EXPECT_THAT(file.refusal("/descriptions", Json::array()),
              HasSubstr("/descriptions: must be as many as the sources"));
}

TEST(SensitivitySummary, IsReadAsItWasWrittenAndFitsItsLists) {
  SummaryFile file(full_sensitivity());
  EXPECT_EQ(file.again(), file.text());
  for (const char* list : {"/points/0/position", "/points/0/paired_m", "/points/0/answered"})
    EXPECT_THAT(file.refusal(list, Json::array()), HasSubstr("/points: must have a number for each factor"));
}

TEST(TrackingSummary, IsReadAsItWasWritten) {
  const ScratchFolder folder;
  EXPECT_FALSE(read_beside<TrackingSummary>(folder.path()));
  TrackingSummary summary{
      .study = "s", .simulated = true, .repaired = true, .views = {}, .exchanges = {}, .clocks = {}};
  summary.views = {{"walking", "k1", "wrist", "inferred", 10, 4},
                   {"walking", "k2", "wrist", "inferred", 9, 1}};
  summary.exchanges = {{"walking", "k1", 10, 4, 2}, {"walking", "k2", 9}};
  summary.clocks = {{"t", "found", 0.1, 0.05, 0.15, 1.0, kNoNumber, 0.9, 0.5, true}};
  summary.rays = {{"t", 7, "", 0.01, 0.02, 0.5, 0.4, 0.6}};
  summary.predictions = {{"walking", "mean", 4, {0.01}}};
  write_beside(folder.path(), summary);
  const std::string text = read_file(folder / "tracking.json");
  const auto read = read_beside<TrackingSummary>(folder.path());
  ASSERT_TRUE(read);
  write_beside(folder.path(), *read);
  EXPECT_EQ(read_file(folder / "tracking.json"), text);
}

TEST(ResultsKinds, AreToldApart) {
  const ScratchFolder folder;
  write_results(folder.path(), two_cells());
  EXPECT_EQ(results_kind(folder.path()), StudyKind::threshold_sweep);
  EXPECT_THAT(message_of([&] { read_summary(folder.path()); }),
              HasSubstr("/kind: is \"threshold_sweep\"; results of kind \"accuracy\" are needed here"));
  write_summary(folder.path(), ResultsSummary{});
  EXPECT_EQ(results_kind(folder.path()), StudyKind::accuracy);
  EXPECT_THAT(message_of([&] { read_results<SweepSummary>(folder.path()); }),
              HasSubstr("/kind: is \"accuracy\""));
}

TEST(SweepTimings, AreAFileOfTheirOwnThatNeedNotBeThere) {
  const ScratchFolder folder;
  EXPECT_FALSE(read_beside<SweepTimings>(folder.path()));
  write_beside(folder.path(),
               SweepTimings{"sweep", "a processor", 500, 7, {{0, 1, 2, 310.5, 300.0, 40.0, 39.5}}});
  const auto read = read_beside<SweepTimings>(folder.path());
  ASSERT_TRUE(read);
  EXPECT_EQ(read->repeats, 7u);
  EXPECT_EQ(read->cells.at(0).scalar_median_ns, 310.5);
  EXPECT_EQ(read->cells[0].range, 2u);
}

TEST(StageTimings, AreReadAsTheyWereWrittenAndMayBeMissing) {
  const ScratchFolder folder;
  EXPECT_FALSE(read_beside<StageTimings>(folder.path()).has_value());
  write_beside(folder.path(),
               StageTimings{"table4", "a processor", {{"trilateration", "linear", small_spread()}}});
  const auto read = read_beside<StageTimings>(folder.path());
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(read->processor, "a processor");
  ASSERT_EQ(read->stages.size(), 1u);
  EXPECT_EQ(read->stages[0].method, "linear");
  EXPECT_EQ(read->stages[0].time.n, 6u);
}

TEST(PrintedTable4, HasThePapersNumbers) {
  const PrintedTable4 paper = printed_table4();
  std::uint64_t frames = 0, samples = 0;
  for (const PrintedTable4::Row& row : paper.rows) {
    frames += row.frames;
    samples += row.clock_samples;
  }
  ASSERT_EQ(paper.rows.size(), 6u);
  EXPECT_TRUE(std::isnan(paper.rows[0].to_ms));
  EXPECT_EQ(paper.rows[1].frames, 11926u);
  EXPECT_EQ(frames + paper.lost_frames, paper.frames);
  EXPECT_EQ(samples, 71998u);
  EXPECT_EQ(paper.frames * paper.clients, 72000u);
}

}  // namespace
}  // namespace trilat
