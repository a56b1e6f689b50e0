// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/results/table.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/accuracy/shown/accuracy_shown.h"
#include "pipeline/accuracy/take/plan.h"
#include "pipeline/accuracy/wand_poses.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/error_cells.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr const char* kMeanAlone = R"("methods": [{"method": "mean"}])";

StudySpec staged(const std::string& stages, const std::string& more = "") {
  return study_of(R"("alignments": ["none"], )" + more + R"("stages": [)" + stages + "], " + kMeanAlone);
}

std::string refusal(const std::string& stages) {
  return message_of([&] { staged(stages); });
}

TEST(Stages, EachKeepsWhatTheOneBeforeChanged) {
  const StudySpec study = staged(R"({"name": "a", "poses": "wand"}, {"name": "b", "frames": "newest"},
      {"name": "c", "poses": "printed", "repair_exchanges": false})",
                                 R"("sensor_clocks": "causal", )");
  ASSERT_EQ(study.stages.size(), 3u);
  EXPECT_EQ(study.stages[1].poses, PoseSource::wand);
  EXPECT_EQ(study.stages[1].frames, FrameChoice::newest);
  EXPECT_TRUE(study.stages[1].repair_exchanges);
  EXPECT_EQ(study.stages[2].poses, PoseSource::printed);
  EXPECT_EQ(study.stages[2].frames, FrameChoice::newest);
  EXPECT_FALSE(study.stages[2].repair_exchanges);
  for (const Stage& stage : study.stages) EXPECT_EQ(stage.sensor_clocks, SensorClocks::causal);
  const Json once = json_of(study);
  EXPECT_EQ(once, json_of(parse_study(once, "study.json", {})));
}

TEST(Stages, WhatTheyCannotHaveIsRefused) {
  EXPECT_THAT(refusal(""), HasSubstr("/stages: must hold at least one entry"));
  EXPECT_THAT(refusal(R"({"name": "a"}, {"name": "a"})"), HasSubstr("which an earlier stage has"));
  EXPECT_THAT(refusal(R"({"poses": "wand"})"), HasSubstr("/stages/0/name: is missing"));
  EXPECT_THAT(refusal(R"({"name": "a", "pose": "wand"})"), HasSubstr("poses"));
  EXPECT_THAT(refusal(R"({"name": "a", "poses": "wands"})"), HasSubstr("did you mean \"wand\"?"));
  EXPECT_THAT(refusal(R"({"name": "a", "clock": "motion"})"), HasSubstr("/stages/0/clock"));
}

// Exact trackers, so that a moving person's error is that of times alone.
TEST(Stages, EveryTakeIsEvaluatedAtEachAndTheTableSaysWhatChanges) {
  const ScratchFolder folder;
  const Campaign campaign = simulate_into(folder / "campaign", without_noise(walking_spec(3, 4.0)));
  const StudySpec study =
      staged(R"({"name": "exact", "sensor_clocks": "exact"}, {"name": "offline", "sensor_clocks": "offline"},
                {"name": "live", "sensor_clocks": "causal"}, {"name": "newest", "frames": "newest"})");
  const ResultsSummary summary = execute_study(study, campaign, folder / "results", {});
  EXPECT_THAT(summary.conditions, ElementsAre("exact", "offline", "live", "newest"));
  EXPECT_EQ(summary.participants, 3u);
  const auto error_m = [&](const char* stage) {
    return find_cell(summary, "mean", stage, kAverageGroup, "none")->mae_m;
  };
  EXPECT_NEAR(error_m("offline"), error_m("exact"), 1e-4);
  EXPECT_GT(error_m("live"), error_m("exact"));
  EXPECT_LT(error_m("live"), error_m("exact") + 0.002);  // a millisecond of a walk
  EXPECT_GT(error_m("newest"), error_m("live") + 0.01);  // some 40 ms
  const std::vector<Table> tables = stages_tables(summary, {"exact", "offline", "live", "newest"});
  ASSERT_EQ(tables.size(), 1u);
  ASSERT_EQ(tables[0].columns[2].key, "change_cm");
  EXPECT_TRUE(std::isnan(tables[0].rows[0][2].number.value()));
  const TableValue& change = tables[0].rows[3][2];
  EXPECT_NEAR(change.number.value(), 100.0 * (error_m("newest") - error_m("live")), 0.01);
  EXPECT_LT(change.low, change.number);
  const std::vector<std::string> findings = stages_findings(summary, {"exact", "offline", "live", "newest"});
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_THAT(findings[0], HasSubstr("The largest step is \"newest\": +"));
  ResultsSummary noted = summary;
  noted.notes = {{"p01-walking.1", false, "x", "first"}, {"p01-walking.4", false, "x", "fourth"}};
  EXPECT_THAT(stages_warnings(noted, {"exact", "offline", "live", "newest"}),
              testing::Contains(HasSubstr("1 thing, namely: take p01-walking.1")));
  const std::vector<Figure> figures = stages_figures(summary, {"exact", "offline", "live", "newest"});
  ASSERT_EQ(figures.size(), 1u);
  EXPECT_NEAR(figures[0].series.at(0).points.at(3).x, 100.0 * error_m("newest"), 1e-9);
}

TEST(Stages, OfSeveralActivitiesEachHasItsOwnConditionsAndTable) {
  const ScratchFolder folder;
  SimulationSpec spec = without_noise(walking_spec(1, 1.0));
  spec.activities.push_back(spec.activities[0]);
  spec.activities[1].activity = Activity::standing;
  const Campaign campaign = simulate_into(folder / "campaign", spec);
  const StudySpec study = staged(R"({"name": "a"}, {"name": "b", "frames": "newest"})");
  const ResultsSummary summary = execute_study(study, campaign, folder / "results", {});
  EXPECT_THAT(summary.conditions,
              testing::UnorderedElementsAre("walking, a", "walking, b", "standing, a", "standing, b"));
  EXPECT_EQ(stages_tables(summary, {"a", "b"}).size(), 2u);
}

TEST(SensorClocks, ExactOnesAreTheSimulatorsAndOfSimulationsAlone) {
  const ScratchFolder folder;
  const Campaign campaign = simulate_into(folder / "campaign", walking_spec(1, 12.0));
  const SessionReader session(campaign.takes[0].session);
  const Json truth = read_json(folder / "campaign/p01-walking/truth.json");
  for (std::size_t s = 0; s < session.header().sensors.size(); ++s) {
    const SensorClockMap exact = clock_of(session, s, SensorClocks::exact);
    const SensorClockMap offline = clock_of(session, s, SensorClocks::offline);
    for (const FrameStamp& stamp : session.stamps(s, FrameStream::bodies, 0, session.counts(s).body_frames)) {
      const Json& sensor = truth["sensors"][s];
      const double since_ns = static_cast<double>(stamp.device_ticks * 100 -
                                                  sensor["sensor_clock_origin_ns"].get<std::int64_t>());
      const double host_ns = since_ns * (1.0 + sensor["host_from_sensor_drift"].get<double>());
      EXPECT_NEAR(static_cast<double>(exact(stamp).ns - sensor["host_at_origin_ns"].get<std::int64_t>()),
                  host_ns, 2.0);
      EXPECT_NEAR((offline(stamp) - exact(stamp)).seconds(), 0.0, 5e-4);
      EXPECT_EQ(clock_of(session, s, SensorClocks::printed)(stamp).ns, stamp.arrival_ns - 20'000'000);
    }
  }
  std::filesystem::remove(folder / "campaign/p01-walking/truth.json");
  EXPECT_THAT(message_of([&] { clock_of(session, 0, SensorClocks::exact); }),
              HasSubstr("\"exact\" is for simulations"));
}

TEST(WandPoses, ACampaignWithoutAWandIsRefusedWithTheKey) {
  const ScratchFolder folder;
  HashCache hashes;
  const Campaign campaign{"c", true, {Take{}}, folder.path()};
  const StudySpec study = study_of(std::string(R"("poses": "two_positions", )") + kMeanAlone);
  EXPECT_THAT(message_of([&] { with_wand_poses(study, campaign, folder / "results", hashes, {}); }),
              HasSubstr("/poses: asks for poses by a wand, and the campaign names none: add \"wand\""));
  EXPECT_TRUE(with_wand_poses(study_of(kMeanAlone), campaign, folder / "results", hashes, {})
                  .stage.calibration.empty());
  EXPECT_FALSE(std::filesystem::exists(folder / "results"));
}

// One small recording: a wand that all four sensors see at the first three places.
TEST(WandPoses, TheCampaignsWandPlacesTheSensorsInOptiTracksWorld) {
  const ScratchFolder folder;
  SimulationSpec spec = walking_spec(1, 0.5);
  spec.wand = WandSpec{};
  spec.wand->motion = {4, 0.6, 0.3};
  simulate_into(folder / "campaign", spec);
  const Campaign campaign = read_campaign(folder / "campaign");
  ASSERT_TRUE(campaign.wand.has_value());
  HashCache hashes;
  const Calibration truth = read_calibration(folder / "campaign/calibration.json");
  const StudySpec study =
      staged(R"({"name": "refined", "poses": "wand"}, {"name": "two", "poses": "two_positions"},
                                    {"name": "printed", "poses": "printed"})");
  const StudySpec made = with_wand_poses(study, campaign, folder / "results", hashes, {});
  const std::vector<double> limits_m{0.03, 0.08};
  for (std::size_t stage = 0; stage < limits_m.size(); ++stage) {
    const Calibration calibration = read_calibration(made.stages[stage].calibration);
    EXPECT_EQ(calibration.world, "optitrack");
    for (std::size_t s = 0; s < truth.sensors.size(); ++s)
      EXPECT_LT((calibration.sensors[s].world_from_sensor.translation_m -
                 truth.sensors[s].world_from_sensor.translation_m)
                    .norm(),
                limits_m[stage])
          << made.stages[stage].name << ' ' << truth.sensors[s].name;
  }
  const Calibration printed = read_calibration(made.stages[2].calibration);
  EXPECT_EQ(printed.method, kWithoutTranslation);
  // made again only where the wand is another
  const auto before = std::filesystem::last_write_time(made.stages[0].calibration);
  const StudySpec again = with_wand_poses(study, campaign, folder / "results", hashes, {});
  EXPECT_EQ(again.stages[0].calibration, made.stages[0].calibration);
  EXPECT_EQ(std::filesystem::last_write_time(made.stages[0].calibration), before);
  write_file(campaign.wand->mocap, read_file(campaign.wand->mocap) + "\n");
  EXPECT_NE(with_wand_poses(study, campaign, folder / "results", hashes, {}).stages[0].calibration,
            made.stages[0].calibration);
}

}  // namespace
}  // namespace trilat
