// SPDX-License-Identifier: MIT
#include <cmath>
#include <set>

#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "datasets/results/stored_take.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/errors/condition_errors.h"
#include "pipeline/variations/variations_results.h"
#include "pipeline/variations/variations_study.h"
#include "tests/pipeline/campaigns.h"
#include "tests/support/paths.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// Independent errors along the rays hurt ranges, those across do not.
constexpr const char* kSimulation =
    R"("simulation": {"format": "trilat.simulation", "version": 1, "participants": 1,
       "activities": [{"name": "walking", "duration_s": 1}],
       "body_tracker": {"bias_sigma_m": 0, "view_bias_sigma_m": 0, "own_bias_sigma_m": 0, "jitter_sigma_m": 0,
         "wander_sigma_m": 0, "view_wander_sigma_m": 0, "own_wander_sigma_m": 0.05, "wander_path_m": 0.1,
         "lag_s": 0, "jump_size_m": 0, "exchanged_share": 0, "least_visible_share": 0, "unit_depth_share": 0}})";
constexpr const char* kMethods =
    R"("alignments": ["none"], "clock": "stated", "methods": [{"method": "mean"}, {"method": "nonlinear"}])";
constexpr const char* kRanges =
    R"("points": 12, "ranges": [{"name": "ratio", "setting": "/body_tracker/ray_ratio", "low": 0.1, "high": 5,
       "logarithmic": true}, {"name": "height", "setting": "/rig/heights_m", "values": [[0.6, 2.2, 0.9, 1.9],
       [0.5, 2.0, 1.0, 1.5]]}],
       "comparisons": [{"better": "nonlinear", "than": ["mean"]}])";

Json study_json(const std::string& more) {
  return parse_json(R"({"format": "trilat.study", "version": 1, "kind": "variations", "name": "map", )" +
                        std::string(kSimulation) + ", " + kMethods + ", " + more + "}",
                    "map.json");
}
VariationsSpec spec_of(const std::string& more) {
  return parse_variations(study_json(more), "map.json", {}, {});
}
std::string refusal(const std::string& more) {
  return message_of([&] { spec_of(more); });
}

TEST(VariationsSpec, WhatCannotBeIsRefusedBeforeAnythingIsSimulated) {
  EXPECT_THAT(
      refusal(
          R"("patches": [{"name": "a", "patch": {}}, {"name": "b", "patch": {"body_tracker": {"lags": 1}}}])"),
      AllOf(HasSubstr("/patches/1/patch"), HasSubstr("body_tracker"), HasSubstr("lags"), HasSubstr("lag_s")));
  EXPECT_THAT(refusal(R"("ranges": [{"setting": "/rig/radius_m", "low": 2, "high": 2}])"),
              AllOf(HasSubstr("/ranges/0/high"), HasSubstr("greater than low")));
  EXPECT_THAT(refusal(R"("ranges": [{"setting": "/rig/nothing", "low": 1, "high": 2}])"),
              HasSubstr("/ranges/0/setting"));
  EXPECT_THAT(refusal(R"("ranges": [], "patches": [])"), HasSubstr("give one of them"));
  EXPECT_THAT(refusal(R"("patches": [{"name": "a", "patch": {}}], "conditions": ["flying"])"),
              AllOf(HasSubstr("/conditions: has \"flying\""), HasSubstr("walking")));
  EXPECT_THAT(refusal(R"("patches": [{"name": "a", "patch": {}}], "sensors": ["k1", "k9"])"),
              HasSubstr("/sensors: has \"k9\""));
  // each end is possible by itself, but not both together
  EXPECT_THAT(message_of([&] {
                variations_study(spec_of(R"("ranges": [{"setting": "/sensor/nearest_m", "low": 0, "high": 4},
                    {"setting": "/sensor/farthest_m", "low": 1, "high": 4.5}])"));
              }),
              HasSubstr("farthest_m: must be farther"));
}

TEST(VariationsSpec, PointsLieAllOverTheRangesWithPersonsOfTheirOwn) {
  const VariationsSpec spec = spec_of(kRanges);
  ASSERT_EQ(spec.head.points.size(), 12u);
  std::set<int> quarters;
  for (const VariationPoint& point : spec.head.points) {
    ASSERT_EQ(point.position.size(), 2u);
    quarters.insert(static_cast<int>(4.0 * point.position[0]));
  }
  EXPECT_EQ(quarters, (std::set{0, 1, 2, 3}));
  EXPECT_NEAR(spec.head.ranges[0].value_at(0.5), std::sqrt(0.1 * 5.0), 1e-12);
  EXPECT_EQ(spec.head.ranges[1].text_at(0.9), "[0.5,2.0,1.0,1.5]");
  EXPECT_NE(simulation_at(spec, 0).seed, simulation_at(spec, 1).seed);
  const double ratio = simulation_at(spec, 3).body_tracker.ray_ratio;
  EXPECT_NEAR(ratio, spec.head.ranges[0].value_at(spec.head.points[3].position[0]), 1e-12);
}

TEST(VariationsStudy, FindsWhereTrilaterationPays) {
  const ScratchFolder folder;
  run_study(variations_study(spec_of(kRanges)), folder / "map", {});
  const auto s = read_results<VariationsSummary>(folder / "map");
  const ComparisonShare& in = s.comparisons.at(0).by_alignment.at(0);
  EXPECT_EQ(in.compared, 12u);
  for (const VariationPoint& point : s.points) {
    const double ratio = s.ranges[0].value_at(point.position[0]);
    if (ratio < 0.3) {
      EXPECT_LT(point.paired_m[2], point.paired_m[1]) << ratio;
    } else if (ratio > 2.0) {
      EXPECT_GT(point.paired_m[2], point.paired_m[1]) << ratio;
    }
  }
  EXPECT_EQ(in.decided_by.front().range, "ratio");
  EXPECT_GT(in.decided_by.front().first_order.value, 0.5);
  EXPECT_LT(in.share.low, in.share.value);
  EXPECT_THAT(read_file(folder / "map/points.csv"),
              HasSubstr("point,ratio,height,method,mae_m,answered,problem\n1,"));
  const StoredTables tables = read_beside<StoredTables>(folder / "map").value();
  EXPECT_EQ(tables.tables.front().id, "comparisons");
  EXPECT_EQ(read_beside<StoredFigures>(folder / "map")->figures.size(), 1u);
}

TEST(VariationsStudy, OtherComparisonsSimulateNothingAgain) {
  const ScratchFolder folder;
  const std::string ranges =
      R"("points": 8, "ranges": [{"setting": "/rig/radius_m", "low": 1.9, "high": 2.1}])";
  run_study(variations_study(spec_of(ranges)), folder / "map", {});
  const ItemTally again = run_study(
      variations_study(spec_of(ranges + R"(, "comparisons": [{"better": "mean", "than": ["nonlinear"]}])")),
      folder / "map", {});
  EXPECT_TRUE(again.computed.empty());
  EXPECT_EQ(again.found.size(), 8u);
}

TEST(VariationsStudy, PatchesArePairedByParticipant) {
  const ScratchFolder folder;
  run_study(variations_study(spec_of(R"("patch": {"participants": 3}, "patches": [
      {"name": "as it is", "patch": {}}, {"name": "same", "patch": {}},
      {"name": "exact", "patch": {"body_tracker": {"own_wander_sigma_m": 0}}}])")),
            folder / "map", {});
  const auto s = read_results<VariationsSummary>(folder / "map");
  const Table table = read_beside<StoredTables>(folder / "map")->tables.at(0);
  ASSERT_EQ(table.rows.size(), 3u);
  ASSERT_EQ(table.columns[2].key, "mean_change_cm");
  EXPECT_EQ(table.rows[1][2].number, 0.0);
  EXPECT_LT(*table.rows[2][2].number, -1.0);
  EXPECT_LT(table.rows[2][2].high, 0.0);
  EXPECT_LT(s.points[2].paired_m[0], 0.003);  // interpolation of a hand between frames
}

// A recording without any truth, and seven others.
TEST(VariationsStudy, APointThatCannotBeEvaluatedIsNamedAndTheOthersCount) {
  const ScratchFolder folder;
  const ItemTally tally = run_study(variations_study(spec_of(R"("patches": [{"name": "good", "patch": {}},
      {"name": "blind", "patch": {"mocap": {"gap_share": 1}}}])")),
                                    folder / "map", {});
  EXPECT_EQ(tally.failed.size(), 1u);
  const auto s = read_results<VariationsSummary>(folder / "map");
  EXPECT_EQ(s.failed(), 1u);
  EXPECT_THAT(s.points[1].problem, HasSubstr("holds no ground truth"));
  EXPECT_THAT(read_file(folder / "map/points.csv"), HasSubstr("blind,nonlinear,,,"));
  EXPECT_EQ(read_file(folder / "map/summary.json").find("NaN"), std::string::npos);
}

// Every source of error that the default simulation has is one of the budget's: without them nothing is left
// but what interpolation between frames leaves.
TEST(ErrorBudget, WithoutAnySourceNothingIsLeft) {
  const std::filesystem::path studies = std::filesystem::path(kSourceDir) / "pipeline/studies";
  Json budget = read_json(studies / "error_budget.json"),
       campaign = read_json(studies / "paper_campaign.json");
  budget.erase("scales");
  campaign.erase("scales");
  Json all = Json::object();
  const Json without_any = budget["patches"].back();
  for (const Json& patch : budget["patches"])
    if (patch != without_any) all.merge_patch(patch["patch"]);
  EXPECT_EQ(all, without_any["patch"]);
  budget["patches"] = {without_any};
  budget["patch"].update(
      Json{{"participants", 1u}, {"activities", {{{"name", "walking"}, {"duration_s", 2}}}}});
  const ScratchFolder folder;
  run_study(variations_study(parse_variations(budget, "error_budget.json", {}, campaign)), folder / "budget",
            {});
  const auto s = read_results<VariationsSummary>(folder / "budget");
  const std::size_t methods = s.methods.size();
  for (std::size_t m = 0; m < methods; ++m)
    EXPECT_LT(s.points[0].paired_m[m * methods + m], 0.003) << s.methods[m];
}

VariationPoint point_at(double position, std::vector<double> paired_m) {
  return {.name = "",
          .position = {position},
          .paired_m = std::move(paired_m),
          .answered = {1.0, 1.0, 1.0},
          .person_m = {{}, {}, {}}};
}

// Where a method is silent it is compared nowhere, and that is said.
TEST(VariationsResults, PointsWithoutCommonSamplesAreNotCompared) {
  VariationsSummary s;
  s.alignments = {"rigid"};
  s.methods = {"a", "b", "c"};
  s.ranges = {{.name = "x", .unit = "m", .setting = "/x", .values = {}, .low = 0.0, .high = 10.0}};
  s.comparisons = {{.name = "a before b", .better = "a", .than = {"b"}},
                   {.name = "a before c", .better = "a", .than = {"c"}}};
  for (int k = 0; k < 20; ++k) {
    const double b = k < 5 ? kNoNumber : 1.0;
    // alone a errs 5, where b answers it errs 0.5: only this is compared
    s.points.push_back(point_at(k / 20.0, {5.0, 0.5 * b, 5.0, b, b, b, 4.0, 2.0 * b, 4.0}));
  }
  analyse(s);
  const ComparisonShare& in = s.comparisons[0].by_alignment[0];
  EXPECT_EQ(in.compared, 15u);
  EXPECT_EQ(in.share.value, 1.0);
  EXPECT_NEAR(in.share.low, std::pow(0.025, 1.0 / 15.0), 1e-9);
  EXPECT_NEAR(in.difference_percent.value, -50.0, 1e-9);
  EXPECT_EQ(s.comparisons[1].by_alignment[0].share.value, 0.0);
  EXPECT_NEAR(s.best[2].share.value, 0.25, 1e-12);  // where b answers, each errs less than one of the others
}

// What the results of an accuracy study say of its reference.
TEST(MethodPairs, AreTheDifferencesOfTheResults) {
  const ScratchFolder folder;
  const Campaign campaign = simulate_into(folder / "campaign", walking_spec(3));
  const StudySpec study = study_of(R"("alignments": ["rigid", "none"], "methods": [{"method": "mean"},
      {"method": "nonlinear", "occlusion": "corrected", "fewest_sensors": 4}, {"method": "geometric"}])");
  const ResultsSummary summary = execute_study(study, campaign, folder / "results", {});
  std::vector<TakeTable> tables;
  std::vector<std::string> joints;
  for (const ResultTake& take : result_takes(folder / "results")) {
    const StoredTake stored = open_take(take);
    joints = stored.head().joints;
    tables.push_back({take.id, take.id, take.condition, stored.read_errors()});
  }
  const std::vector<double> paired_m = paired_errors_m(tables, joints, 3, summary.conditions.front());
  std::size_t compared = 0;
  for (const DifferenceCell& cell : summary.differences) {
    if (cell.group != kAverageGroup || cell.alignment != "rigid") continue;
    const auto m =
        static_cast<std::size_t>(std::ranges::find(summary.methods, cell.method) - summary.methods.begin());
    EXPECT_NEAR(paired_m[m * 3] - paired_m[m], cell.difference_m, 1e-9) << cell.method;
    EXPECT_NEAR(paired_m[m], cell.difference_m / cell.percent_of_reference * 100.0, 1e-9) << cell.method;
    ++compared;
  }
  EXPECT_EQ(compared, 2u);
}

}  // namespace
}  // namespace trilat
