// SPDX-License-Identifier: MIT
// Studies without mocap: one sensor after the other is left out, and predicted from the rest.
#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/results/item_store.h"
#include "datasets/results/stored_take.h"
#include "datasets/results/summary.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/error_cells.h"
#include "tests/pipeline/program.h"
#include "tests/pipeline/rewritten_session.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr const char* kMethods =
    R"("alignments": ["none"], "methods": [{"method": "mean"}, {"method": "nonlinear"},
       {"method": "range_bearing", "sigma": "estimated"}])";

Campaign without_mocap(Campaign campaign) {
  for (Take& take : campaign.takes) {
    take.mocap.clear();
    take.mapping.clear();
    take.mocap_start_host_ns = 0;
  }
  return campaign;
}

Campaign blind_campaign(const ScratchFolder& folder, std::uint64_t participants, double duration_s = 1.0) {
  SimulationSpec spec = walking_spec(participants, duration_s);
  spec.body_tracker.least_visible_share = 0.5;
  const Campaign campaign = without_mocap(simulate_into(folder.path() / "campaign", spec));
  write_campaign(folder.path() / "campaign", campaign);
  return read_campaign(folder.path() / "campaign");
}

TEST(LeftOut, ATakeHasATrackForEverySensor) {
  const ScratchFolder folder;
  const Campaign campaign = blind_campaign(folder, 2);
  const Plan plan = make_plan(study_of(kMethods), campaign);
  ASSERT_EQ(plan.rig.size(), 4u);
  EXPECT_TRUE(leaves_sensors_out(plan));
  execute_study(study_of(kMethods), campaign, folder / "results", {});
  const std::vector<ResultTake> takes = result_takes(folder / "results");
  ASSERT_EQ(takes.size(), 2u);
  const StoredTake take = open_take(takes[0]);
  EXPECT_EQ(take.head().tracks, plan.rig);
  std::set<std::uint32_t> quantities;
  for (const ErrorSums& row : take.read_errors().sums)
    if (row.is(Measure::distance)) quantities.insert(row.quantity);
  EXPECT_EQ(quantities.size(), 4 * take.head().joints.size());
}

TEST(LeftOut, TheSensorsTrackedJointsAreTheTruthAndNoMethodSeesThem) {
  const ScratchFolder folder;
  const Plan plan = make_plan(study_of(kMethods), blind_campaign(folder, 1));
  const PlannedTake& planned = plan.takes[0];
  RecordedTake recorded = read_take(plan, planned, {});
  const PersonTake followed = select_person(plan, planned, recorded);
  const PreparedTake data = view_take(plan, planned, followed, std::nullopt, 2, {});
  std::size_t tracked = 0, inferred = 0;
  for (std::size_t i = 0; i < data.time.size(); ++i) {
    for (std::size_t j = 0; j < plan.joints.size(); ++j) {
      const Joint joint = plan.joints[j];
      const bool swapped = data.exchanges.at(i, 2);
      const ObservedBody& before = followed.bodies.at(i, 2);
      const TrackingState state = before.state[static_cast<std::size_t>(swapped ? mirror_of(joint) : joint)];
      const Eigen::Vector3d& truth = data.truth(i, j, plan.joints.size());
      EXPECT_EQ(truth.allFinite(), state == TrackingState::tracked);
      tracked += state == TrackingState::tracked;
      inferred += state == TrackingState::inferred;
      const Eigen::Vector3d seen =
          planned.world_from_sensor[2] * before.at(swapped ? mirror_of(joint) : joint);
      EXPECT_TRUE(!truth.allFinite() || (truth - seen).norm() < 1e-12);
      EXPECT_FALSE(data.bodies.at(i, 2).has(joint));
      EXPECT_TRUE(data.exchanges.at(i, 1) ||
                  data.bodies.at(i, 1).has(joint) == followed.bodies.at(i, 1).has(joint));
    }
  }
  EXPECT_GT(tracked, 100u);
  EXPECT_GT(inferred, 0u);
}

// A sensor that never tracks tells nothing; the others are predicted all the same.
TEST(LeftOut, ASensorThatTracksNothingIsNamed) {
  const ScratchFolder folder;
  Campaign campaign = blind_campaign(folder, 1);
  change_session(campaign.takes[0], folder / "silent.h5",
                 {.bodies = [](std::size_t sensor, BodyFrame& frame) {
                   if (sensor == 0) frame.bodies.clear();
                   return true;
                 }});
  const ResultsSummary summary = execute_study(study_of(kMethods), campaign, folder / "results", {});
  EXPECT_EQ(summary.takes_failed, 0u);
  EXPECT_EQ(std::ranges::count_if(summary.notes,
                                  [](const TakeNote& note) {
                                    return note.text.find("never tracks a joint that is asked for") !=
                                           std::string::npos;
                                  }),
            1);
  EXPECT_GT(find_cell(summary, "mean", "walking", "head", "none")->answered, 50u);
}

TEST(LeftOut, AStudySaysWhatItIsHeldAgainst) {
  const ScratchFolder folder;
  const Campaign campaign = blind_campaign(folder, 2, 2.0);
  const ResultsSummary summary = execute_study(study_of(kMethods), campaign, folder.path() / "results", {});
  EXPECT_TRUE(summary.left_out());
  EXPECT_EQ(summary.takes, 2u);
  EXPECT_EQ(summary.takes_failed, 0u);
  EXPECT_EQ(summary.participants, 2u);
  const auto head = find_cell(summary, "mean", "walking", "head", "none");
  ASSERT_TRUE(head);
  EXPECT_GT(head->mae_m, 0.005);
  EXPECT_LT(head->mae_m, 0.1);
  const auto tracking = read_json_file<TrackingSummary>(folder.path() / "results");
  ASSERT_TRUE(tracking);
  EXPECT_EQ(tracking->rays.size(), 2u);  // once a take, of all sensors
  for (const std::string& method : summary.methods) {
    const auto number = [&](const char* measure, const char* statistic) {
      const Number* found = summary.numbers.find(
          {.condition = "walking", .method = method, .measure = measure, .statistic = statistic});
      return found ? *found : Number{};
    };
    EXPECT_GT(number("range", "mean_abs").value, 0.0);
    EXPECT_LT(number("range", "mean_abs").low, number("range", "mean_abs").value);
    EXPECT_LT(std::abs(number("range", "bias").value), number("range", "mean_abs").value);
    EXPECT_GT(number("bearing", "mean").value, 0.0);
    EXPECT_GT(number("jerk", "mean").value, 0.0);
  }
}

TEST(LeftOut, MocapIsLeftAsideWhenTheStudySaysSo) {
  const ScratchFolder folder;
  const Campaign with = simulate_into(folder.path() / "campaign", walking_spec(1));
  const std::string members = std::string(R"("joints": ["head", "wrist_left"], )") + kMethods;
  const auto head_of = [&](const Campaign& campaign, const std::string& truth, const char* name) {
    return find_cell(execute_study(study_of(members + truth), campaign, folder.path() / name, {}),
                     "nonlinear", "walking", "head", "none")
        ->mae_m;
  };
  const double aside = head_of(with, R"(, "truth": "left_out_sensor")", "aside");
  EXPECT_EQ(aside, head_of(without_mocap(with), "", "without"));
  EXPECT_NE(aside, head_of(with, "", "mocap"));
}

TEST(LeftOut, TheProgramGoesFromACampaignWithoutMocapToATable) {
  const ScratchFolder folder;
  blind_campaign(folder, 2);
  const std::string study = file_with(
      folder, "study.json",
      std::string(R"({"format": "trilat.study", "version": 1, "kind": "accuracy", "name": "own", )") +
          kMethods + "}");
  const std::string campaign = (folder.path() / "campaign").string();
  const auto run = [&](const std::string& output, std::vector<std::string> more) {
    std::vector<std::string> arguments{"run",    study, "--campaign",
                                       campaign, "-o",  (folder.path() / output).string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_trilat(folder, arguments);
  };
  const Ended whole = run("results", {});
  EXPECT_EQ(whole.code, 0) << whole.err;
  EXPECT_THAT(whole.out, HasSubstr("against the sensor left out"));
  EXPECT_THAT(whole.out, HasSubstr("There is no ground truth."));
  EXPECT_THAT(whole.out, HasSubstr("What a sensor sees, predicted from the others"));
  EXPECT_EQ(run("shards", {"--shard", "1/2"}).code, 0);
  EXPECT_EQ(run("shards", {"--shard", "2/2"}).code, 0);
  EXPECT_EQ(run("shards", {}).code, 0);
  for (const char* name : {"summary.json", "tracking.json"})
    EXPECT_EQ(read_file(folder.path() / "shards" / name), read_file(folder.path() / "results" / name))
        << name;
}

TEST(LeftOut, WhatCannotBeJudgedIsRefused) {
  const ScratchFolder folder;
  const Campaign with = simulate_into(folder.path() / "campaign", walking_spec(2));
  Campaign mixed = with;
  mixed.takes[1] = without_mocap(with).takes[1];
  const StudySpec by_mocap = study_of(std::string(R"("truth": "mocap", )") + kMethods);
  const Plan plan = make_plan(by_mocap, mixed);
  EXPECT_TRUE(plan.takes[0].ok);
  EXPECT_FALSE(plan.takes[1].ok);
  EXPECT_THAT(plan.takes[1].problem, HasSubstr("has no \"mocap\" to be judged by"));
  const Campaign blind = without_mocap(with);
  EXPECT_THAT(message_of([&] { make_plan(by_mocap, blind); }), HasSubstr("has no \"mocap\" to be judged by"));
  try {
    make_plan(study_of(std::string(R"("sensors": ["sensor_1"], )") + kMethods), blind);
    FAIL() << "one sensor was left out";
  } catch (const InputError& error) {
    EXPECT_THAT(error.problem(), HasSubstr("one sensor"));
  }
}

TEST(LeftOut, AMappingWithoutMocapIsOfNoUse) {
  const Json json = Json::parse(R"({"format": "trilat.campaign", "version": 1, "name": "c", "takes": [
    {"id": "t", "participant": "p", "session": "s.h5", "calibration": "c.json", "mapping": "m.json"}]})");
  try {
    parse_campaign(json, "campaign.json");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(std::string(error.what()), HasSubstr("/takes/0/mapping"));
    EXPECT_THAT(error.problem(), HasSubstr("without \"mocap\""));
  }
}

// As `init` says of each take: those with motion capture are judged by it, the others by their own sensors.
TEST(LeftOut, TakesWithoutMocapBesideOthersAreAConditionOfTheirOwn) {
  const ScratchFolder folder;
  Campaign campaign = simulate_into(folder / "campaign", walking_spec(2, 2.0));
  campaign.takes[1].mocap.clear();
  campaign.takes[1].mapping.clear();
  const ResultsSummary summary =
      execute_study(study_of(R"("alignments": ["none"], "methods": [{"method": "mean"}])"), campaign,
                    folder / "results", {});
  EXPECT_EQ(summary.takes_failed, 0u);
  EXPECT_EQ(summary.takes, 2u);
  EXPECT_EQ(summary.truth, kMocapTruth);
  EXPECT_THAT(summary.conditions, testing::ElementsAre("walking", "walking, against a left-out sensor"));
  for (const std::string& condition : summary.conditions) {
    const auto cell = find_cell(summary, "mean", condition, "wrist", "none");
    ASSERT_TRUE(cell) << condition;
    EXPECT_GT(cell->answered, 50u) << condition;
  }
  EXPECT_EQ(
      std::ranges::count_if(
          summary.notes, [](const TakeNote& note) { return note.text.find("has no motion capture") == 0; }),
      1);
}

}  // namespace
}  // namespace trilat
