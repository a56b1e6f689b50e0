// SPDX-License-Identifier: MIT
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/results/studies/tracking_summary.h"
#include "datasets/synthetic/tracker/body_tracker_spec.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/accuracy/evaluate_take.h"
#include "pipeline/accuracy/take/take_data.h"
#include "tests/pipeline/campaigns.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

constexpr const char* kMean = R"("methods": [{"method": "mean"}])";

// Persons watched by trackers that are exact but for what is switched on.
SimulationSpec tracking_spec(std::uint64_t participants, double duration_s) {
  SimulationSpec spec = walking_spec(participants, duration_s);
  spec.body_tracker = exact_body_tracker();
  spec.body_tracker.least_visible_share = 0.5;
  return spec;
}

StudySpec study(const std::string& members) { return study_of(R"("alignments": ["none"], )" + members); }

double mae_m(const ResultsSummary& summary, const std::string& method, const std::string& group) {
  const SummaryCell* cell = find_cell(summary, method, "walking", group, "none");
  return cell ? cell->mae_m : kNoNumber;
}

TEST(Tracking, ExchangedSidesAreFoundAndPutRight) {
  const ScratchFolder folder;
  SimulationSpec spec = tracking_spec(2, 12.0);
  spec.body_tracker.back_view_angle_rad = 2.1;
  spec.body_tracker.exchanged_share = 1.0;
  const Campaign campaign = simulate_into(folder / "campaign", spec);
  const ResultsSummary repaired = execute_study(study(kMean), campaign, folder / "repaired", {});
  const ResultsSummary as_given = execute_study(study(std::string(R"("repair_exchanges": false, )") + kMean),
                                                campaign, folder / "given", {});
  EXPECT_GT(mae_m(as_given, "mean", "shoulder"), 0.05);
  EXPECT_LT(mae_m(repaired, "mean", "shoulder"), 0.015);  // clocks and movement only
  for (const SummaryCell& cell : repaired.cells)
    if (cell.group != kAverageGroup) {
      EXPECT_LT(cell.max_m, 0.05) << cell.group;  // nor at the ends of stretches
    }
  const auto tracking = read_beside<TrackingSummary>(folder / "repaired");
  ASSERT_TRUE(tracking && tracking->repaired);
  std::uint64_t exchanged = 0, rightly = 0, found = 0;
  for (const ExchangeRow& row : tracking->exchanges) {
    EXPECT_TRUE(row.truth_known);
    EXPECT_EQ(row.stretches_found, row.true_stretches) << row.sensor;
    exchanged += row.exchanged;
    rightly += row.rightly;
    found += row.found;
  }
  EXPECT_GT(exchanged, 100u);
  EXPECT_GE(rightly * 100, exchanged * 99);
  EXPECT_LE((found - rightly) * 1000, found);
}

TEST(Tracking, WhatTheSimulatorHidesIsWhatTheTrackerInfers) {
  const ScratchFolder folder;
  const Campaign campaign = simulate_into(folder / "campaign", tracking_spec(1, 6.0));
  execute_study(study(R"("methods": [{"method": "mean", "occlusion": "corrected"}])"), campaign,
                folder / "results", {});
  const auto tracking = read_beside<TrackingSummary>(folder / "results");
  ASSERT_TRUE(tracking);
  std::uint64_t hidden = 0, inferred = 0, rightly = 0, by_method = 0;
  for (const ViewRow& row : tracking->views) {
    ASSERT_TRUE(row.truth_known);
    if (row.rule == "inferred") {
      hidden += row.hidden;
      inferred += row.rejected;
      rightly += row.rightly;
    }
    if (row.rule == "method: mean") by_method += row.rightly;
  }
  EXPECT_GT(hidden, 100u);
  // an instant between two frames takes the worse state of the two and the truth of the nearer
  EXPECT_GT(static_cast<double>(rightly), 0.85 * static_cast<double>(inferred));
  EXPECT_GT(static_cast<double>(rightly), 0.85 * static_cast<double>(hidden));
  EXPECT_GT(static_cast<double>(by_method), 0.85 * static_cast<double>(hidden));
}

TEST(Tracking, AnUnoccludedSensorIsBetterThanAHiddenOne) {
  const ScratchFolder folder;
  SimulationSpec spec = tracking_spec(2, 6.0);
  spec.body_tracker.inferred_error_sigma_m.fill(0.2);
  const Campaign campaign = simulate_into(folder / "campaign", spec);
  const ResultsSummary summary = execute_study(study(R"("methods": [{"method": "mean"},
                                         {"method": "mean", "name": "chosen", "occlusion": "corrected"}])"),
                                               campaign, folder / "results", {});
  EXPECT_LT(mae_m(summary, "chosen", "elbow"), 0.5 * mae_m(summary, "mean", "elbow"));
}

TEST(Tracking, AClockThatIsOffIsFoundAndCanBeCorrected) {
  const ScratchFolder folder;
  Campaign campaign = simulate_into(folder / "campaign", synchronised(without_noise(walking_spec(2, 20.0))));
  for (Take& take : campaign.takes) take.mocap_start_host_ns += 80'000'000;  // stated 80 ms late
  const ResultsSummary checked = execute_study(study(kMean), campaign, folder / "checked", {});
  const auto tracking = read_beside<TrackingSummary>(folder / "checked");
  ASSERT_EQ(tracking->clocks.size(), 2u);
  for (const ClockRow& row : tracking->clocks) {
    EXPECT_EQ(row.status, "found");
    EXPECT_FALSE(row.applied);
    EXPECT_NEAR(row.offset_s, 0.080, 5e-4);
    EXPECT_LE(row.low_s, row.offset_s);
  }
  EXPECT_GT(mae_m(checked, "mean", "wrist"), 0.03);
  const ResultsSummary moved =
      execute_study(study(std::string(R"("clock": "motion", )") + kMean), campaign, folder / "moved", {});
  EXPECT_LT(mae_m(moved, "mean", "wrist"), 0.001);
  EXPECT_TRUE(read_beside<TrackingSummary>(folder / "moved")->clocks[0].applied);
  execute_study(study(std::string(R"("clock": "stated", )") + kMean), campaign, folder / "stated", {});
  EXPECT_TRUE(read_beside<TrackingSummary>(folder / "stated")->clocks.empty());
}

TEST(Tracking, AClockThatMotionDoesNotTellStaysAsStatedWithANote) {
  const ScratchFolder folder;
  SimulationSpec spec = walking_spec(1, 10.0);
  spec.activities[0].activity = Activity::standing;
  const Campaign campaign = simulate_into(folder / "campaign", spec);
  const ResultsSummary summary =
      execute_study(study(std::string(R"("clock": "motion", )") + kMean), campaign, folder / "results", {});
  ASSERT_EQ(summary.takes_failed, 0u);
  ASSERT_FALSE(summary.notes.empty());
  EXPECT_THAT(summary.notes.front().text, HasSubstr("too_little_motion"));
}

TEST(Tracking, OfTwoPersonsInViewTheOneWithTheMarkersIsEvaluated) {
  const ScratchFolder folder;
  SimulationSpec spec = tracking_spec(2, 8.0);
  spec.bystanders = 1;
  const Campaign campaign = simulate_into(folder / "campaign", spec);
  const ResultsSummary summary = execute_study(study(kMean), campaign, folder / "results", {});
  ASSERT_EQ(summary.takes_failed, 0u);
  EXPECT_LT(mae_m(summary, "mean", "head"), 0.02);
  EXPECT_LT(mae_m(summary, "mean", "wrist"), 0.05);
  ASSERT_FALSE(summary.notes.empty());
  EXPECT_THAT(summary.notes.front().text, HasSubstr("they are 2 persons"));
}

TEST(Tracking, OcclusionByDepthNeedsRecordedDepth) {
  const ScratchFolder folder;
  const Campaign campaign = simulate_into(folder / "campaign", walking_spec(1));
  const ResultsSummary summary = execute_study(
      study(R"("methods": [{"method": "mean", "occlusion": "depth"}])"), campaign, folder / "results", {});
  EXPECT_EQ(summary.takes_failed, 1u);
  EXPECT_THAT(summary.notes.front().text, HasSubstr("holds no depth frames"));
}

TEST(Tracking, RecordedDepthShowsWhatIsHidden) {
  const ScratchFolder folder;
  SimulationSpec spec = tracking_spec(1, 1.5);
  spec.depth.takes = true;
  const Campaign campaign = simulate_into(folder / "campaign", spec);
  execute_study(
      study(R"("methods": [{"method": "mean", "occlusion": "depth", "inferred_is_occluded": false}])"),
      campaign, folder / "results", {});
  std::uint64_t hidden = 0, rejected = 0, rightly = 0;
  const auto tracking = read_beside<TrackingSummary>(folder / "results");
  ASSERT_TRUE(tracking);
  for (const ViewRow& row : tracking->views) {
    if (row.rule != "hidden in depth") continue;
    hidden += row.hidden;
    rejected += row.rejected;
    rightly += row.rightly;
  }
  EXPECT_GT(rejected, 20u);
  EXPECT_GT(static_cast<double>(rightly), 0.6 * static_cast<double>(rejected));
  EXPECT_GT(static_cast<double>(rightly), 0.3 * static_cast<double>(hidden));
}

TEST(TrackingSummary, IsReadAsItWasWritten) {
  const ScratchFolder folder;
  TrackingSummary summary{"study", true, true, {}, {}, {}};
  summary.views.push_back({"walking", "k1", "wrist", "inferred", 10, 4, true, 5, 3});
  summary.views.push_back({"walking", "k1", "wrist", "crossed, corrected", 10, 4, false, 0, 0});
  summary.exchanges.push_back({"walking", "k2", 100, 7, 2, true, 8, 6, 3, 1});
  summary.clocks.push_back(
      {"p01", "ambiguous", kNoNumber, kNoNumber, kNoNumber, kNoNumber, kNoNumber, 0.9, 0.95, false});
  write_beside(folder.path(), summary);
  const std::string once = read_file(folder / "tracking.json");
  const auto read = read_beside<TrackingSummary>(folder.path());
  ASSERT_TRUE(read);
  EXPECT_EQ(read->views[0].rightly, 3u);
  EXPECT_FALSE(read->views[1].truth_known);
  EXPECT_EQ(read->exchanges[0].stretches_found, 1u);
  EXPECT_TRUE(std::isnan(read->clocks[0].offset_s));
  write_beside(folder.path(), *read);
  EXPECT_EQ(read_file(folder / "tracking.json"), once);
}

TEST(TrackingSummary, OfAnotherKindIsRefusedAndMissingIsNone) {
  const ScratchFolder folder;
  EXPECT_FALSE(read_beside<TrackingSummary>(folder.path()));
  write_file(folder / "tracking.json", R"({"format": "something"})");
  EXPECT_THROW(read_beside<TrackingSummary>(folder.path()), InputError);
}

}  // namespace
}  // namespace trilat
