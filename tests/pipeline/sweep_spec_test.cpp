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
  return message_of([&] { sweep_of(members); });
}

TEST(SweepSpec, TrialsThatCannotBeCountedAreRefused) {
  EXPECT_THAT(sweep_refusal(kOneRig + R"(, "trials": 1000000000000, "vary": {"joint": ["centre", "volume"],
      "error_model": ["range_signed", "displacement", "gaussian"], "threshold_unit": ["cm2", "m2"],
      "gradient": ["printed", "corrected"],
      "stop": ["printed", "objective", "step"], "start": ["linear", "squared_ranges"],
      "error_cm": [[0, 1], [0, 2], [0, 3], [0, 4], [0, 5], [0, 6]],
      "threshold": [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16]})"),
              HasSubstr("cells is more than 2^53 trials in all"));
}

// An interpretation has two cells here, one a threshold; the threshold varies fastest.
TEST(SweepSpec, SkipsWhatContradictsItselfAndCountsIt) {
  const SweepSpec spec =
      sweep_of(kOneRig + R"(, "solver": {"stop": "step"}, "vary": {"damping": ["none", "lm"],
      "gradient": ["printed", "corrected"], "threshold_unit": ["cm2", "m2"], "threshold": [1, 0.5]})");
  std::vector<std::string> cells;
  for (const SweepSetting& s : spec.cells)
    cells.push_back(fmt::format("{}/{}/{}/{}", s.threshold_unit, s.gradient, s.damping, s.threshold));
  EXPECT_THAT(cells,
              testing::ElementsAre("cm2/printed/none/1", "cm2/printed/none/0.5", "cm2/corrected/none/1",
                                   "cm2/corrected/none/0.5", "cm2/corrected/lm/1", "cm2/corrected/lm/0.5",
                                   "m2/printed/none/1", "m2/printed/none/0.5"));
  EXPECT_EQ(spec.skipped, 4u);
}

TEST(SweepSpec, AThresholdCountsInItsUnit) {
  const SweepSpec spec =
      sweep_of(kOneRig + R"(, "solver": {"stop": "printed", "gradient": "printed", "threshold": 0.5,
      "error_cm": [5, 15]}, "vary": {"threshold_unit": ["cm2", "m2"]})");
  ASSERT_EQ(spec.cells.size(), 2u);
  EXPECT_DOUBLE_EQ(trials_of(spec, spec.cells[0]).options.threshold_m2, 0.5e-4);
  EXPECT_DOUBLE_EQ(trials_of(spec, spec.cells[0]).options.printed_unit_m, 0.01);
  EXPECT_DOUBLE_EQ(trials_of(spec, spec.cells[1]).options.threshold_m2, 0.5);
  EXPECT_DOUBLE_EQ(trials_of(spec, spec.cells[1]).options.printed_unit_m, 1.0);
  EXPECT_DOUBLE_EQ(trials_of(spec, spec.cells[0]).model.high_m, 0.15);
}

// Each word of a choice is another value of its enum.
TEST(SweepSpec, WordsAreWhatTheySay) {
  const auto trials = [](const char* solver) {
    const SweepSpec spec = sweep_of(kOneRig + R"(, "solver": )" + solver);
    return trials_of(spec, spec.cells.front());
  };
  const SweepTrials usual = trials("{}");
  EXPECT_EQ(usual.model.joint, TrialJoint::volume);
  EXPECT_EQ(usual.model.error, TrialError::range_signed);
  EXPECT_EQ(usual.options.gradient, Gradient::corrected);
  EXPECT_EQ(usual.options.curvature, Curvature::gauss_newton);
  EXPECT_EQ(usual.options.stop, StopRule::objective);
  EXPECT_EQ(usual.options.damping, Damping::none);
  EXPECT_EQ(usual.options.start, Start::linear);
  EXPECT_FALSE(usual.has_guess);
  const SweepTrials other = trials(
      R"({"joint": "centre", "error_model": "gaussian", "curvature": "newton", "stop": "step",
          "damping": "lm", "start": "squared_ranges"})");
  EXPECT_EQ(other.model.joint, TrialJoint::centre);
  EXPECT_EQ(other.model.error, TrialError::gaussian);
  EXPECT_EQ(other.options.curvature, Curvature::newton);
  EXPECT_EQ(other.options.stop, StopRule::step);
  EXPECT_EQ(other.options.damping, Damping::lm);
  EXPECT_EQ(other.options.start, Start::squared_ranges);
  EXPECT_TRUE(other.has_guess);
}

TEST(SweepSpec, TheResolvedSettingsReadBackAsTheSameSweep) {
  const SweepSpec spec =
      sweep_of(kOneRig + R"(, "solver": {"damping": "lm", "curvature": "newton", "stop": "step"},
      "vary": {"start": ["squared_ranges", "linear"], "error_cm": [[0, 7]]}, "trials": 7, "seed": 9)");
  const Json resolved = parse_json(json_of(spec).dump(), "resolved.json");
  EXPECT_EQ(json_of(parse_sweep(resolved, "resolved.json")).dump(), resolved.dump());
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
  EXPECT_EQ(table1.cells.size(), 2u * 4u * 12u);
  EXPECT_EQ(table1.skipped, 0u);
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
