// SPDX-License-Identifier: MIT
// Campaigns and studies that are odd, but not broken: numbers stay away where there are none, nothing ends.
#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/accuracy/tracking_summary.h"
#include "reports/write_report.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/error_cells.h"
#include "tests/pipeline/rewritten_session.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::Field;
using testing::HasSubstr;

constexpr const char* kOnlyMean = R"("methods": [{"method": "mean"}])";

// The report of a study, which must not print what is no number.
std::string report_of(const ScratchFolder& folder, const std::string& results) {
  const ReportFiles report = write_report({folder / results}, folder / "report");
  for (const auto& path : report.written) {
    const std::string text = read_file(path);
    for (const char* word : {"nan ", "| nan", ",nan", "inf "})
      EXPECT_EQ(text.find(word), std::string::npos) << path << ": " << word;
  }
  return read_file(folder / "report/report.md");
}

TEST(OddInput, AMappedJointThatNoSensorEverSeesHasNoNumbers) {
  const ScratchFolder folder;
  Campaign campaign = simulate_into(folder / "campaign", walking_spec(2));
  constexpr auto kHead = static_cast<std::size_t>(Joint::head);
  for (Take& take : campaign.takes)
    change_session(take, folder / (take.id + ".h5"), {[](std::size_t, BodyFrame& frame) {
                     for (Body& body : frame.bodies) body.tracking_state[kHead] = 0;
                     return true;
                   }});
  const ResultsSummary summary = execute_study(
      study_of(R"("alignments": ["mean", "none", "rigid", "joint_offset"], "methods": [{"method": "mean"},
          {"method": "nonlinear"}, {"method": "kalman"}, {"method": "rts"}, {"method": "window"},
          {"method": "median", "occlusion": "corrected"}])"),
      campaign, folder / "results", {});
  EXPECT_EQ(summary.takes_failed, 0u);
  int cells = 0;
  for (const ErrorCell& cell : error_cells(summary)) {
    if (cell.group != "head") continue;
    ++cells;
    const std::string what = cell.method + " " + cell.alignment;
    EXPECT_EQ(cell.answered, 0u) << what;
    EXPECT_GT(cell.asked, 0u) << what;
    EXPECT_EQ(cell.coverage(), 0.0) << what;
    EXPECT_TRUE(std::isnan(cell.mae_m) && std::isnan(cell.rmse_m) && std::isnan(cell.max_m)) << what;
  }
  EXPECT_EQ(cells, 6 * 4);
  EXPECT_GT(find_cell(summary, "rts", "walking", "wrist", "none")->coverage(), 0.9);
  report_of(folder, "results");
}

TEST(OddInput, ATruthShorterThanABlockIsEvaluatedWhereItIs) {
  const ScratchFolder folder;
  Campaign campaign = simulate_into(folder / "campaign", walking_spec(3));
  campaign.takes[0].mocap_start_host_ns += 700'000'000;
  const ResultsSummary summary =
      execute_study(study_of(std::string(R"("alignments": ["mean"], "clock": "motion", )") + kOnlyMean),
                    campaign, folder / "results", {});
  EXPECT_EQ(summary.takes_failed, 0u);
  const auto cell = find_cell(summary, "mean", "walking", "wrist", "mean");
  ASSERT_TRUE(cell);
  EXPECT_EQ(cell->clusters, 3u);
  EXPECT_LT(cell->mae_low_m, cell->mae_m);
  EXPECT_GT(cell->mae_high_m, cell->mae_m);
  const auto tracking = read_json_file<TrackingSummary>(folder / "results");
  ASSERT_TRUE(tracking);
  for (const ClockOffsetRow& clock : tracking->clocks) {
    EXPECT_FALSE(clock.applied) << clock.status;  // a second of motion tells nothing
    EXPECT_TRUE(std::isnan(clock.offset_s)) << clock.status;
  }
  report_of(folder, "results");
}

TEST(OddInput, TakesOfDifferentRatesStandInOneCampaign) {
  const ScratchFolder folder;
  SimulationSpec slow = walking_spec(1, 3.0);
  slow.sensor.rate_hz = 15.0;
  slow.mocap.rate_hz = 240.0;
  Campaign campaign = simulate_into(folder / "campaign", walking_spec(1, 3.0));
  campaign.takes.push_back(simulate_into(folder / "slow", slow).takes[0]);
  campaign.takes[1].id = "slow";
  campaign.takes.push_back(campaign.takes[0]);
  campaign.takes[2].id = "mixed";
  change_session(campaign.takes[2], folder / "mixed.h5", {[](std::size_t sensor, BodyFrame& frame) {
                   return sensor != 1 || frame.stamp.sequence % 2 == 0;  // k2 at 15 Hz
                 }});
  const ResultsSummary summary =
      execute_study(study_of(R"("alignments": ["none"], "methods": [{"method": "mean"}, {"method": "rts"},
                  {"method": "nonlinear"}, {"method": "single"}])"),
                    campaign, folder / "results", {});
  EXPECT_EQ(summary.takes_failed, 0u);
  for (const ErrorCell& cell : error_cells(summary)) {
    EXPECT_GT(cell.coverage(), 0.85) << cell.method << " " << cell.group;
    EXPECT_LT(cell.mae_m, 0.12) << cell.method << " " << cell.group;
  }
}

TEST(OddInput, ASensorThatStopsEarlyCostsOnlyMethodsThatCannotDoWithoutIt) {
  const ScratchFolder folder;
  Campaign campaign = simulate_into(folder / "campaign", walking_spec(1, 3.0));
  change_session(campaign.takes[0], folder / "stopped.h5", {[](std::size_t sensor, BodyFrame& frame) {
                   return sensor != 1 || frame.stamp.sequence < 30;  // k2 after a second
                 }});
  const ResultsSummary summary =
      execute_study(study_of(R"("alignments": ["none"], "methods": [{"method": "mean"}, {"method": "linear"},
                    {"method": "single", "sensors": ["k2"], "name": "k2"}])"),
                    campaign, folder / "results", {});
  const auto cell = [&](const char* method) { return find_cell(summary, method, "walking", "head", "none"); };
  EXPECT_GE(cell("mean")->asked, 86u);  // of 3 s, less 1 % of the truth
  EXPECT_GT(cell("mean")->coverage(), 0.97);
  EXPECT_LT(cell("linear")->coverage(), 0.4);
  EXPECT_LT(cell("k2")->coverage(), 0.4);
  EXPECT_EQ(cell("k2")->asked, cell("mean")->asked);
  EXPECT_THAT(report_of(folder, "results"), HasSubstr("k2 recorded only 1.0 s of 3.0 s"));
}

TEST(OddInput, SensorsThatRecordAtNoTimeTogetherAreNamed) {
  const ScratchFolder folder;
  Campaign campaign = simulate_into(folder / "campaign", walking_spec(1, 3.0));
  change_session(campaign.takes[0], folder / "apart.h5", {[](std::size_t sensor, BodyFrame& frame) {
                   return sensor == 1 ? frame.stamp.sequence > 60 : frame.stamp.sequence < 30;
                 }});
  execute_study(study_of(R"("alignments": ["none"], "methods": [{"method": "mean"}])"), campaign,
                folder / "results", {});
  EXPECT_THAT(report_of(folder, "results"),
              HasSubstr("k2 begins 1.1 s after k1 ends (are their times of clocks that have nothing in"));
}

TEST(OddInput, TwoLostFramesAreBridgedWhateverTheSensorsDriftIs) {
  const ScratchFolder folder;
  SimulationSpec spec = walking_spec(1, 3.0);
  spec.sensor.dropped_share = 0.0;
  Campaign campaign = simulate_into(folder / "campaign", spec);
  change_session(campaign.takes[0], folder / "lossy.h5", {[](std::size_t, BodyFrame& frame) {
                   return frame.stamp.sequence % 10 > 1 || frame.stamp.sequence == 0;
                 }});
  const ResultsSummary summary =
      execute_study(study_of(R"("alignments": ["none"], "methods": [{"method": "single"}])"), campaign,
                    folder / "results", {});
  for (const char* method : {"single k1", "single k2", "single k3", "single k4"})
    EXPECT_GT(find_cell(summary, method, "walking", "head", "none")->coverage(), 0.95) << method;
}

TEST(OddInput, FramesWhoseTimeDoesNotRiseAreCountedAndNamed) {
  const ScratchFolder folder;
  Campaign campaign = simulate_into(folder / "campaign", walking_spec(1));
  std::int64_t ticks = 0, arrival_ns = 0;
  change_session(campaign.takes[0], folder / "twice.h5", {[&](std::size_t s, BodyFrame& frame) {
                   if (s == 1 && frame.stamp.sequence > 10 && frame.stamp.sequence <= 13) {
                     frame.stamp.device_ticks = ticks;
                     frame.stamp.arrival_ns = arrival_ns;
                   } else if (s == 1) {
                     ticks = frame.stamp.device_ticks;
                     arrival_ns = frame.stamp.arrival_ns;
                   }
                   return true;
                 }});
  const ResultsSummary summary = execute_study(
      study_of(std::string(R"("alignments": ["none"], )") + kOnlyMean), campaign, folder / "results", {});
  EXPECT_THAT(summary.notes,
              Contains(Field(&TakeNote::text, HasSubstr("k2: 3 frames have a time that is not after"))));
}

TEST(OddInput, WhatTheIntervalOfOneParticipantIsOfIsSaid) {
  const ScratchFolder folder;
  execute_study(study_of(std::string(R"("alignments": ["mean"], )") + kOnlyMean),
                simulate_into(folder / "campaign", walking_spec(1)), folder / "results", {});
  EXPECT_THAT(report_of(folder, "results"), HasSubstr("say nothing of other people"));
}

TEST(OddInput, AMethodThatFailsEverywhereIsADashInEveryTable) {
  const ScratchFolder folder;
  const ResultsSummary summary = execute_study(
      study_of(
          R"("alignments": ["mean", "joint_offset"], "reference": "never", "methods": [{"method": "mean"},
          {"method": "nonlinear", "name": "never", "sensors": ["k1", "k2"]}])"),
      simulate_into(folder / "campaign", walking_spec(2)), folder / "results", {});
  ASSERT_FALSE(error_cells(summary).empty());
  for (const ErrorCell& cell : error_cells(summary))
    if (cell.method == "never") {
      EXPECT_EQ(cell.answered, 0u);
    }
  for (const Number& number : summary.numbers.all()) EXPECT_TRUE(number.against.empty());
  report_of(folder, "results");
}

std::string run_refusal(const std::string& members) {
  const ScratchFolder folder;
  const Campaign campaign = simulate_into(folder / "campaign", walking_spec(1, 0.2));
  const std::string message =
      message_of([&] { execute_study(study_of(members), campaign, folder / "results", {}); });
  EXPECT_FALSE(std::filesystem::exists(folder / "results")) << members;
  return message;
}

TEST(OddInput, WhatTheCampaignDoesNotHaveIsRefusedWithWhatItHas) {
  const std::string methods = kOnlyMean;
  EXPECT_THAT(run_refusal(R"("conditions": ["walking", "flying"], )" + methods),
              AllOf(HasSubstr("/conditions: has \"flying\""), HasSubstr("its activities are \"walking\"")));
  EXPECT_THAT(run_refusal(R"("reference": "magic", )" + methods),
              AllOf(HasSubstr("/reference: is \"magic\""), HasSubstr("none of its methods: \"mean\"")));
  EXPECT_THAT(run_refusal(R"("methods": [{"method": "mean", "sensors": ["k1", "k9"]}])"),
              AllOf(HasSubstr("k9"), HasSubstr("k1, k2, k3, k4")));
  EXPECT_THAT(run_refusal(R"("methods": [{"method": "linear", "reference": "k9"}])"),
              AllOf(HasSubstr("k9"), HasSubstr("k1, k2, k3, k4")));
  EXPECT_THAT(run_refusal(R"("sensors": ["k1", "k2"], "methods": [{"method": "single", "sensors": ["k3"]}])"),
              AllOf(HasSubstr("k3"), HasSubstr("k1, k2")));
}

TEST(OddInput, AnActivityWithTheNameOfOccludedSamplesIsRefused) {
  const ScratchFolder folder;
  Campaign campaign = simulate_into(folder / "campaign", walking_spec(2));
  campaign.takes[1].activity = "walking, occluded";
  const auto run = [&](const std::string& members) {
    return message_of([&] { make_plan(study_of(members + kOnlyMean), campaign, {}); });
  };
  EXPECT_THAT(run(R"("occluded_apart": true, )"), HasSubstr("rename the activity"));
  EXPECT_EQ(run(""), "no error");
}

TEST(OddInput, OccludedApartWithNothingOccludedHasAnEmptyCondition) {
  const ScratchFolder folder;
  SimulationSpec spec = without_noise(walking_spec(2));
  spec.activities[0].marker_joints = {Joint::head};  // nothing crosses in front of it
  const ResultsSummary summary =
      execute_study(study_of(std::string(R"("alignments": ["none"], "occluded_apart": true, )") + kOnlyMean),
                    simulate_into(folder / "campaign", spec), folder / "results", {});
  ASSERT_EQ(summary.conditions.size(), 2u);
  EXPECT_GT(find_cell(summary, "mean", "walking", "head", "none")->answered, 0u);
  const auto occluded = find_cell(summary, "mean", summary.conditions[1], "head", "none");
  if (occluded) {
    EXPECT_EQ(occluded->answered, 0u);
    EXPECT_TRUE(std::isnan(occluded->mae_m));
  }
  report_of(folder, "results");
}

TEST(OddInput, TakesOfTwoInstantsCanBeTrainedOnOrNot) {
  const ScratchFolder folder;
  SimulationSpec spec = synchronised(walking_spec(2, 0.05));
  spec.sensor.dropped_share = 0.0;
  const Campaign campaign = simulate_into(folder / "campaign", spec);
  for (const char* share : {"0.05", "0.5", "0.95"}) {
    const ResultsSummary summary = execute_study(
        study_of(std::string(R"("alignments": ["held_out", "joint_offset", "none"], "training_share": )") +
                 share + ", " + kOnlyMean),
        campaign, folder / "results", {});
    EXPECT_EQ(summary.takes_failed, 0u) << share;
    EXPECT_GE(find_cell(summary, "mean", "walking", "head", "none")->answered, 2u) << share;
    for (const char* alignment : {"held_out", "joint_offset"}) {
      const auto cell = find_cell(summary, "mean", "walking", "head", alignment);
      if (!cell) continue;  // nothing is left to be evaluated
      EXPECT_EQ(cell->answered > 0, std::isfinite(cell->mae_m)) << share << " " << alignment;
    }
    report_of(folder, "results");
  }
}

}  // namespace
}  // namespace trilat
