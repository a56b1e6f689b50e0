// SPDX-License-Identifier: MIT
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/synthetic/tracker/body_tracker_spec.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/accuracy/evaluate_take.h"
#include "pipeline/accuracy/take/take_data.h"
#include "pipeline/accuracy/tracking_summary.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/error_cells.h"
#include "tests/pipeline/rewritten_session.h"
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
  const auto cell = find_cell(summary, method, "walking", group, "none");
  return cell ? cell->mae_m : kNaN;
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
  for (const ErrorCell& cell : error_cells(repaired))
    if (cell.group != kAverageGroup) {
      EXPECT_LT(cell.max_m, 0.05) << cell.group;  // nor at the ends of stretches
    }
  const auto tracking = read_json_file<TrackingSummary>(folder / "repaired");
  ASSERT_TRUE(tracking && tracking->repaired);
  double found = 0.0;
  for (const CheckRow& row : tracking->checks) found += row.what == "sides exchanged" ? row.value : 0.0;
  EXPECT_GT(found, 0.3);  // of the instants, over all sensors
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
  const auto tracking = read_json_file<TrackingSummary>(folder / "checked");
  ASSERT_EQ(tracking->clocks.size(), 2u);
  for (const ClockOffsetRow& row : tracking->clocks) {
    EXPECT_EQ(row.status, "found");
    EXPECT_FALSE(row.applied);
    EXPECT_NEAR(row.offset_s, 0.080, 5e-4);
    EXPECT_LE(row.low_s, row.offset_s);
  }
  EXPECT_GT(mae_m(checked, "mean", "wrist"), 0.03);
  const ResultsSummary moved =
      execute_study(study(std::string(R"("clock": "motion", )") + kMean), campaign, folder / "moved", {});
  EXPECT_LT(mae_m(moved, "mean", "wrist"), 0.001);
  EXPECT_TRUE(read_json_file<TrackingSummary>(folder / "moved")->clocks[0].applied);
  execute_study(study(std::string(R"("clock": "stated", )") + kMean), campaign, folder / "stated", {});
  EXPECT_TRUE(read_json_file<TrackingSummary>(folder / "stated")->clocks.empty());
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
  const SimulationSpec spec = tracking_spec(1, 8.0);
  Campaign campaign = simulate_into(folder / "campaign", spec);
  add_bodies_of(campaign.takes[0], simulate_other_person(folder / "other", spec), folder / "two.h5");
  const ResultsSummary summary = execute_study(study(kMean), campaign, folder / "results", {});
  ASSERT_EQ(summary.takes_failed, 0u);
  EXPECT_LT(mae_m(summary, "mean", "head"), 0.02);
  EXPECT_LT(mae_m(summary, "mean", "wrist"), 0.05);
  EXPECT_THAT(summary.notes,
              testing::Contains(testing::Field(&TakeNote::text, HasSubstr("they are 2 persons"))));
}

}  // namespace
}  // namespace trilat
