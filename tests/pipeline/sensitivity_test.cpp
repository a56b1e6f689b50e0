// SPDX-License-Identifier: MIT
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "evaluators/metrics/sobol_indices.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/errors/summarise.h"
#include "pipeline/sensitivity/sensitivity_analysis.h"
#include "pipeline/sensitivity/sensitivity_study.h"
#include "reports/tables/tables.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/program.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr const char* kSimulation =
    R"("simulation": {"format": "trilat.simulation", "version": 1,
       "activities": [{"name": "walking", "duration_s": 1}],
       "body_tracker": {"bias_sigma_m": 0, "view_bias_sigma_m": 0, "own_bias_sigma_m": 0, "jitter_sigma_m": 0,
         "wander_sigma_m": 0, "view_wander_sigma_m": 0, "own_wander_sigma_m": 0.05, "wander_path_m": 0.1,
         "lag_s": 0, "jump_size_m": 0, "exchanged_share": 0, "least_visible_share": 0, "unit_depth_share": 0}})";
constexpr const char* kMethods =
    R"("alignments": ["none"], "clock": "stated", "participants": 1, "rows": 4,
       "methods": [{"method": "mean"}, {"method": "nonlinear"}])";
constexpr const char* kSpace =
    R"("space": [{"name": "ratio", "setting": "/body_tracker/ray_ratio", "low": 0.1,
       "high": 5, "logarithmic": true}, {"name": "height", "setting": "/rig/heights_m", "values": [[0.6, 2.2, 0.9, 1.9],
       [0.5, 2.0, 1.0, 1.5]]}])";
constexpr const char* kClaims = R"("claims": [{"better": "nonlinear", "than": ["mean"]}])";

Json study_json(const std::string& space = kSpace, const std::string& claims = kClaims,
                const std::string& more = "") {
  return parse_json(R"({"format": "trilat.study", "version": 1, "kind": "sensitivity", "name": "map", )" +
                        std::string(kSimulation) + ", " + kMethods + ", " + space + ", " + claims + more +
                        "}",
                    "map.json");
}

SensitivitySpec spec_of(const Json& json) { return parse_sensitivity(json, "map.json", {}, {}); }

TEST(SensitivitySpec, SettingsThatContradictEachOtherAreRefusedBeforeAnythingIsSimulated) {
  // each end is possible by itself, but not both together
  const Json json = study_json(R"("space": [{"setting": "/sensor/nearest_m", "low": 0, "high": 4},
      {"setting": "/sensor/farthest_m", "low": 1, "high": 4.5}])");
  EXPECT_THAT(message_of([&] { sensitivity_study(spec_of(json)); }),
              HasSubstr("farthest_m: must be farther"));
}

TEST(SensitivitySpec, PositionsAreValuesOfTheFactors) {
  const SensitivitySpec spec = spec_of(study_json());
  EXPECT_NEAR(spec.head.value_at(0, 0.5), std::sqrt(0.1 * 5.0), 1e-12);
  EXPECT_EQ(spec.head.text_at(1, 0.9), "[0.5,2.0,1.0,1.5]");
  const SimulationSpec there = simulation_at(spec, {1.0, 0.9}, 7);
  EXPECT_NEAR(there.body_tracker.ray_ratio, 5.0, 1e-12);
  EXPECT_EQ(there.rig.heights_m[1], 2.0);
  EXPECT_EQ(there.seed, 7u);
  EXPECT_EQ(simulation_at(spec, {kNoNumber, kNoNumber}, 7).body_tracker.ray_ratio,
            default_body_tracker().ray_ratio);
}

// Independent errors along the rays hurt ranges, those across do not: what an own model of them says, too.
TEST(SensitivityStudy, FindsWhereTrilaterationPays) {
  const ScratchFolder folder;
  run_study(sensitivity_study(spec_of(study_json())), folder / "map", {});
  const SensitivitySummary s = read_sensitivity_summary(folder / "map");
  ASSERT_EQ(s.points.size(), 24u);
  for (const SensitivityPoint& point : s.points) {
    const double ratio = std::isfinite(point.position[0]) ? s.value_at(0, point.position[0]) : 1.0;
    if (ratio < 0.3) {
      EXPECT_LT(point.paired_m[2], point.paired_m[1]) << ratio;
    }
    if (ratio > 0.8) {
      EXPECT_GT(point.paired_m[2], point.paired_m[1]) << ratio;
    }
  }
  EXPECT_GT(s.claims[0].default_percent.low, 20.0);
  EXPECT_GT(s.claims[0].share.value, 0.0);
  EXPECT_LT(s.claims[0].share.value, 1.0);
  EXPECT_GT(s.claims[0].factors[0].total.value, s.claims[0].factors[1].total.value);
  EXPECT_THAT(read_file(folder / "map/points.csv"), HasSubstr("design,row,ratio,height,method,mae_m"));
}

TEST(SensitivityVerb, TablesReportAndSlices) {
  const ScratchFolder folder;
  write_file(
      folder / "map.json",
      study_json(kSpace, kClaims, R"(, "slices": [{"x": "height", "y": "ratio", "steps": 2}])").dump());
  const std::string map = folder / "map.json", results = folder / "results";
  const Ended plan = run_trilat(folder, {"run", map, "--dry-run"});
  EXPECT_THAT(plan.out, HasSubstr("28 campaigns of 1 participants over 2 settings"));
  const Ended ended = run_trilat(folder, {"run", map, "-o", results});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(ended.out, AllOf(HasSubstr("Where each claim holds, simulated"),
                               HasSubstr("nonlinear errs less than mean")));
  const Ended report = run_trilat(folder, {"report", results, "-o", folder / "report"});
  EXPECT_EQ(report.code, 0) << report.err;
  EXPECT_THAT(read_file(folder / "report/report.md"),
              HasSubstr("simulated campaigns all over the space of settings"));
}

// All frames of every sensor are lost at one value: those campaigns fail, the others count.
TEST(SensitivityVerb, CampaignsThatFailAreNamedAndTheExitCodeSaysSo) {
  const ScratchFolder folder;
  write_file(folder / "map.json",
             study_json(R"("space": [{"name": "ratio", "setting": "/body_tracker/ray_ratio", "low": 0.1,
                 "high": 5, "logarithmic": true},
                 {"name": "lost", "setting": "/sensor/dropped_share", "values": [0.01, 1]}])")
                 .dump());
  const Ended ended = run_trilat(folder, {"run", folder / "map.json", "-o", folder / "results"});
  EXPECT_EQ(ended.code, 1) << ended.err;
  EXPECT_THAT(ended.err, AllOf(HasSubstr("failed: "), HasSubstr("campaigns have no errors")));
  EXPECT_THAT(read_file(folder / "results/points.csv"), HasSubstr("has no frames"));
}

// A difference that one factor decides alone, with a known break-even.
TEST(SensitivityAnalysis, SharesBreakEvenAndIndicesOfAKnownDifference) {
  SensitivitySummary s;
  s.rows = 64;
  s.seed = 1;
  s.alignments = {"rigid", "none"};
  s.parts = {{"small x", "x", 0.0, 2.0}};
  s.methods = {"a", "b"};
  s.factors = {{.name = "x", .unit = "m", .setting = "/x", .values = {}, .low = 0.0, .high = 10.0},
               {.name = "y", .unit = "", .setting = "/y", .values = {"one", "two"}}};
  s.claims = {{.name = "a before b", .better = "a", .than = {"b"}}};
  for (const std::vector<double>& position : saltelli_design(s.factors.size(), s.rows))
    s.points.push_back({.design = "space",
                        .row = s.points.size() / 4,
                        .position = position,
                        .paired_m = {0.7 + position[0], 0.7 + position[0], 1.0, 1.0, 0.5, 0.5, 1.0, 1.0},
                        .answered = {1.0, 1.0}});
  analyse(s);
  const SensitivityClaim& claim = s.claims[0];
  EXPECT_NEAR(claim.share.value, 0.3, 0.02);
  ASSERT_EQ(claim.side_by_side.size(), 4u);
  EXPECT_EQ(claim.side_by_side[0].share.value, claim.share.value);
  EXPECT_EQ(claim.side_by_side[1].alignment, "none");  // there a always has half of b's error
  EXPECT_EQ(claim.side_by_side[1].share.value, 1.0);
  EXPECT_NEAR(claim.side_by_side[1].difference_percent.value, -50.0, 1e-9);
  EXPECT_EQ(claim.side_by_side[2].part, "small x");
  EXPECT_EQ(claim.side_by_side[2].share.value, 1.0);  // 0.7 + u is below 1 for u up to 0.3
  std::set<std::uint64_t> rows;                       // with a point in the part: only these are trials
  for (const SensitivityPoint& point : s.points)
    if (point.position[0] <= 0.2) rows.insert(point.row);
  EXPECT_LT(rows.size(), 40u);
  EXPECT_NEAR(claim.side_by_side[2].share.low, std::pow(0.025, 1.0 / static_cast<double>(rows.size())),
              1e-12);
  EXPECT_NEAR(static_cast<double>(claim.side_by_side[2].compared), 0.2 * 64 * 4, 8.0);
  EXPECT_NEAR(claim.difference_percent.value, 16.5, 1.0);    // exp of the mean of ln(0.7 + u), less 1
  EXPECT_NEAR(claim.factors[0].break_even.value, 3.0, 0.5);  // the logarithm is no line
  EXPECT_NEAR(claim.factors[0].total.value, 1.0, 0.1);       // of 64 rows
  EXPECT_NEAR(claim.factors[1].total.value, 0.0, 1e-9);
  EXPECT_TRUE(std::isnan(claim.factors[1].break_even.value));
  EXPECT_EQ(claim.factors[1].bins.size(), 2u);
  EXPECT_NEAR(s.best_share[0].value, 0.3, 0.02);
}

// Where a method is silent in the space it is compared nowhere, and that is said.
TEST(SensitivityAnalysis, PointsWithoutCommonSamplesAreCountedAndNotCompared) {
  SensitivitySummary s;
  s.study = "map";
  s.rows = 16;
  s.alignments = {"rigid"};
  s.methods = {"a", "b", "c"};
  s.factors = {{.name = "x", .unit = "m", .setting = "/x", .values = {}, .low = 0.0, .high = 10.0},
               {.name = "y", .unit = "m", .setting = "/y", .values = {}, .low = 0.0, .high = 1.0}};
  s.claims = {{.name = "a before b", .better = "a", .than = {"b"}},
              {.name = "a before c", .better = "a", .than = {"c"}}};
  std::size_t silent = 0;
  for (const std::vector<double>& position : saltelli_design(s.factors.size(), s.rows)) {
    const bool is_silent = position[0] < 0.25;
    silent += is_silent ? 1 : 0;
    const double b = is_silent ? kNoNumber : 1.0;
    // alone a errs 5, where b answers it errs 0.5: only this is compared
    s.points.push_back({.design = "space",
                        .row = s.points.size() / 4,
                        .position = position,
                        .paired_m = {5.0, 0.5 * b, 5.0, b, b, b, 4.0, 2.0 * b, 4.0},
                        .answered = {1.0, is_silent ? 0.0 : 0.3, 1.0}});
  }
  analyse(s);
  ASSERT_GT(silent, 0u);
  EXPECT_EQ(s.claims[0].silent, silent);
  EXPECT_EQ(s.claims[0].share.value, 1.0);
  EXPECT_NEAR(s.claims[0].share.low, std::pow(0.025, 1.0 / static_cast<double>(s.rows)), 1e-12);
  EXPECT_NEAR(s.claims[0].difference_percent.value, -50.0, 1e-9);
  EXPECT_EQ(s.claims[1].silent, 0u);
  EXPECT_EQ(s.claims[1].share.value, 0.0);
  // c errs less than a everywhere; where b answers, each errs less than one of the others
  EXPECT_EQ(s.best_share[0].value, 0.0);
  EXPECT_NEAR(s.best_share[2].value, static_cast<double>(silent) / 64.0, 1e-12);
  EXPECT_EQ(s.best_share[1].value, 0.0);
  EXPECT_THAT(sensitivity_sentences(s)[0],
              HasSubstr(fmt::format(
                  "campaigns without a sample that both methods answer do not count: {} of 64", silent)));
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
  for (const SummaryCell& cell : summary.cells)
    if (cell.group == kAverageGroup && cell.method == "mean") {
      EXPECT_NEAR(paired_m[cell.alignment == "rigid" ? 0 : 9], cell.mae_m, 1e-9) << cell.alignment;
    }
}

}  // namespace
}  // namespace trilat
