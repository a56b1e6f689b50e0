// SPDX-License-Identifier: MIT
#include <map>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/accuracy/shown/accuracy_shown.h"
#include "pipeline/accuracy/take/take_data.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/rewritten_session.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

constexpr const char* kWithHidden = R"("alignments": ["none"], "methods": [{"method": "nonlinear"},
    {"method": "nonlinear", "name": "hidden left out", "occlusion": "hidden"}])";

// Somebody who swings the arms before trackers that are exact, and infer just what is hidden from them.
SimulationSpec swinging_spec() {
  SimulationSpec spec = synchronised(without_noise(walking_spec(1, 6.0)));
  spec.activities[0].activity = Activity::arm_swing;
  spec.body_tracker.least_visible_share = default_body_tracker().least_visible_share;
  return spec;
}

TEST(HiddenViews, AreThoseThatATrackerWhichKnowsThemInfers) {
  const ScratchFolder folder;
  const Campaign campaign = simulate_into(folder / "c", swinging_spec());
  execute_study(study_of(kWithHidden), campaign, folder / "out", {});
  const auto tracking = read_json_file<TrackingSummary>(folder / "out");
  std::uint64_t hidden = 0;
  for (const RuleRow& row : tracking->rules) {
    if (row.rule == "inferred" && row.hidden > 50) {  // few are the ends of stretches
      EXPECT_GT(static_cast<double>(row.both), 0.95 * static_cast<double>(row.hidden)) << row.group;
      EXPECT_GT(static_cast<double>(row.both), 0.95 * static_cast<double>(row.marked)) << row.group;
      hidden += row.hidden;
    }
    EXPECT_LE(row.both, std::min(row.hidden, row.marked));
    EXPECT_LE(std::max(row.hidden, row.marked), row.views);
  }
  EXPECT_GT(hidden, 100u);
  std::vector<std::string> ids;
  for (const Table& table : tracking_tables(*tracking)) ids.push_back(table.id);
  EXPECT_THAT(ids, testing::Contains("rules"));
}

// One sensor of the four sees no person, so three quarters of the views judge the rules.
TEST(HiddenViews, RulesAreJudgedByTheViewsThatSeeTheJoint) {
  const ScratchFolder folder;
  Campaign campaign = simulate_into(folder / "c", swinging_spec());
  const auto rules = [&](const char* name) {
    execute_study(study_of(kWithHidden), campaign, folder / name, {});
    std::map<std::pair<std::string, std::string>, RuleRow> by_name;
    const auto tracking = read_json_file<TrackingSummary>(folder / name);
    for (const RuleRow& row : tracking->rules) by_name[{row.rule, row.group}] = row;
    return by_name;
  };
  const auto all = rules("all");
  std::uint64_t marked = 0, both = 0;
  for (const auto& [name, row] : all)
    if (name.first == "equation 8, corrected") {
      marked += row.marked;
      both += row.both;
    }
  EXPECT_GT(marked, 50u);
  EXPECT_GT(both, 50u);
  EXPECT_LE(both, marked);
  change_session(campaign.takes[0], campaign.takes[0].session.parent_path() / "blind.h5",
                 {[](std::size_t s, BodyFrame& frame) {
                   if (s == 0) frame.bodies.clear();
                   return true;
                 }});
  const auto blind = rules("blind");
  ASSERT_EQ(blind.size(), all.size());
  for (const auto& [name, row] : blind) EXPECT_EQ(4 * row.views, 3 * all.at(name).views) << name.first;
}

TEST(HiddenViews, WhereNobodyKnowsThemTheirMethodsAreLeftOutWithANote) {
  const ScratchFolder folder;
  const Campaign campaign = simulate_into(folder / "c", swinging_spec());
  std::filesystem::remove(campaign.takes[0].session.parent_path() / "truth.csv");
  const ResultsSummary summary = execute_study(study_of(kWithHidden), campaign, folder / "out", {});
  EXPECT_THAT(summary.methods, testing::ElementsAre("nonlinear"));
  std::string notes;
  for (const TakeNote& note : summary.notes) notes += note.text;
  EXPECT_THAT(notes, HasSubstr("is evaluated without hidden left out: simulations alone know"));
  EXPECT_THAT(message_of([&] {
                execute_study(study_of(R"("methods": [{"method": "mean", "occlusion": "hidden"}])"), campaign,
                              folder / "other", {});
              }),
              HasSubstr("simulations of generated persons alone know"));
}

// Exact ranges and joints: the range error is rounding, and GDOP what the sensors' directions give.
TEST(Bounds, AreOfTheTruthsGeometryAndTheRangesErrors) {
  const ScratchFolder folder;
  const Campaign campaign = simulate_into(folder / "c", synchronised(without_noise(walking_spec(1, 2.0))));
  const Plan plan = make_plan(study_of(R"("joints": ["head"], "methods": [{"method": "mean"}])"), campaign);
  PreparedTake data = load_take(plan, plan.takes[0], {});
  double gdop = 0.0, count = 0.0;
  for (std::size_t i = 0; i < data.time.size(); ++i) {
    const Eigen::Vector3d& truth_m = data.truth(i, 0, 1);
    if (!truth_m.allFinite() || !data.bodies.at(i, 0).has(Joint::head)) continue;
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    for (const RigidTransform& sensor : plan.takes[0].world_from_sensor) {
      const Eigen::Vector3d u = (truth_m - sensor.translation_m).normalized();
      normal += u * u.transpose();
    }
    gdop += std::sqrt(normal.inverse().trace());
    count += 1.0;
  }
  const std::vector<BoundRow> exact = bounds_of(plan, plan.takes[0], data);
  ASSERT_EQ(exact.size(), 1u);
  EXPECT_EQ(exact[0].n, static_cast<std::uint64_t>(count));
  EXPECT_NEAR(exact[0].mean_gdop(), gdop / count, 1e-9);
  EXPECT_LT(exact[0].range_error_m(), 1e-4);
  // ranges that are all 2 cm too long: the joint lies so much farther out on every ray
  for (std::size_t i = 0; i < data.time.size(); ++i)
    for (std::size_t s = 0; s < 4; ++s) {
      Eigen::Vector3f& head_m = data.bodies.at(i, s).joint_in_sensor_m[static_cast<std::size_t>(Joint::head)];
      head_m *= 1.0f + 0.02f / head_m.norm();
    }
  const std::vector<BoundRow> longer = bounds_of(plan, plan.takes[0], data);
  EXPECT_NEAR(longer[0].range_error_m(), 0.02, 1e-4);
  EXPECT_NEAR(longer[0].bound_m(), 0.02 * longer[0].mean_gdop(), 1e-5);
}

}  // namespace
}  // namespace trilat
