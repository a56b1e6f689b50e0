// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_spec.h"

#include <filesystem>

#include <gmock/gmock.h>

#include "datasets/paper/printed_tables.h"
#include "datasets/results/results_file.h"
#include "pipeline/accuracy/methods/study_spec.h"
#include "tests/pipeline/sweeps.h"
#include "tests/support/paths.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

std::string sweep_refusal(const std::string& members) {
  return message_of([&] { sweep_plan_of(members); });
}

TEST(SweepSpec, TrialsThatCannotBeCountedAreRefused) {
  EXPECT_THAT(sweep_refusal(kOneRig + R"(, "trials": 1000000000000, "joints": ["centre", "volume"],
      "error_models": ["range_signed", "displacement", "gaussian"], "threshold_units": ["cm2", "m2"],
      "stops": ["printed", "objective", "step"], "starts": ["linear", "squared_ranges"],
      "error_ranges_cm": [[0, 1], [0, 2], [0, 3], [0, 4], [0, 5], [0, 6]],
      "thresholds": [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16])"),
              HasSubstr("cells is more than 2^53 trials in all"));
}

TEST(SweepPlan, SkipsWhatContradictsItselfAndCountsIt) {
  const SweepPlan plan = sweep_plan_of(kOneRig + R"(, "dampings": ["none", "lm"], "stops": ["step"],
      "threshold_units": ["cm2", "m2"])");
  std::vector<std::string> ids;
  for (const SweepReading& reading : plan.readings) ids.push_back(reading.text.id);
  EXPECT_THAT(ids, testing::ElementsAre("a/volume/range_signed/cm2/printed/gauss_newton/step/none/linear",
                                        "a/volume/range_signed/cm2/corrected/gauss_newton/step/none/linear",
                                        "a/volume/range_signed/cm2/corrected/gauss_newton/step/lm/linear",
                                        "a/volume/range_signed/m2/printed/gauss_newton/step/none/linear"));
  EXPECT_EQ(plan.skipped, 4u);
  EXPECT_EQ(plan.cells(), 4u * 12u);
}

TEST(SweepPlan, AThresholdCountsInItsUnit) {
  const SweepPlan plan = sweep_plan_of(kOneRig + R"(, "threshold_units": ["cm2", "m2"], "stops": ["printed"],
      "gradients": ["printed"], "thresholds": [0.5], "error_ranges_cm": [[5, 15]])");
  EXPECT_DOUBLE_EQ(options_of(plan, {0, 0, 0}).threshold_m2, 0.5e-4);
  EXPECT_DOUBLE_EQ(options_of(plan, {0, 0, 0}).printed_unit_m, 0.01);
  EXPECT_DOUBLE_EQ(options_of(plan, {1, 0, 0}).threshold_m2, 0.5);
  EXPECT_DOUBLE_EQ(options_of(plan, {1, 0, 0}).printed_unit_m, 1.0);
  EXPECT_DOUBLE_EQ(trials_of(plan, {0, 0, 0}).high_m, 0.15);
}

TEST(SweepSpec, TheResolvedSettingsReadBackAsTheSameSweep) {
  const SweepSpec spec = sweep_of(kOneRig + R"(, "error_ranges_cm": [[0, 5]], "dampings": ["lm"], "trials": 7,
      "starts": ["squared_ranges", "linear"], "curvatures": ["newton"], "stops": ["step"], "seed": 9)");
  const Json resolved = parse_json(resolved_json(spec).dump(), "resolved.json");
  EXPECT_EQ(resolved_json(parse_sweep(resolved, "resolved.json")).dump(), resolved.dump());
}

TEST(SweepSpec, SensorsOfACircleStandInEqualSteps) {
  const SweepRig rig = sweep_of(kOneRig).rigs.at(0);
  EXPECT_NEAR(rig.sensors_m[0][0], 2.0, 1e-15);
  EXPECT_NEAR(rig.sensors_m[1][2], 2.0, 1e-15);
  EXPECT_NEAR(rig.sensors_m[3][2], -2.0, 1e-15);
  EXPECT_EQ(rig.sensors_m[3][1], 2.3);
}

TEST(SweepStudies, ThoseOfThePaperCanBeComputed) {
  const std::filesystem::path folder = std::filesystem::path(kSourceDir) / "pipeline/studies";
  const auto read = [&](const char* name) {
    Json study = read_json(folder / name);
    study.erase("scales");  // of `trilat reproduce`
    return parse_sweep(study, name);
  };
  const SweepSpec table1 = read("table1.json");
  EXPECT_EQ(make_sweep_plan(table1, "table1.json").readings.size(), 8u);
  EXPECT_EQ(table1.trials, 5000u);
  EXPECT_GT(table1.time_problems, 0u);
}

TEST(PrintedTable1, HasThePapersNumbers) {
  const PrintedTable1 table = printed_table1();
  ASSERT_EQ(table.rows.size(), 4u);
  EXPECT_EQ(table.rows[2].threshold, 1e-4);
  EXPECT_THAT(table.rows[2].error_cm, testing::ElementsAre(14.2, 7.3, 3.9));
  EXPECT_THAT(table.rows[3].time_us, testing::ElementsAre(1040.0, 783.0, 651.0));
  EXPECT_TRUE(table.rows[0].time_is_below);
  EXPECT_FALSE(table.rows[1].time_is_below);
}

}  // namespace
}  // namespace trilat
