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

std::string refusal_of_rig(const std::string& members) {
  return sweep_refusal(R"("rigs": [{"name": "a", )" + members + "}]");
}

TEST(SweepSpec, ErrorsNameTheJsonPointerAndWhatWouldBeRight) {
  EXPECT_EQ(sweep_refusal(kOneRig), "no error");
  const std::pair<std::string, const char*> cases[] = {
      {R"("thresholds": [1, 0])", "sweep.json /thresholds/1: must be greater than 0, is 0"},
      {R"("thresholds": [-1e-4])", "sweep.json /thresholds/0: must be greater than 0, is -0.0001"},
      {R"("thresholds": [])", "sweep.json /thresholds: must hold at least one threshold"},
      {R"("thresholds": [1, 2, 1])", "sweep.json /thresholds: has 1 twice"},
      {R"("thresholds": ["1"])", "sweep.json /thresholds: must be a number, is the text \"1\""},
      {R"("thresholds": 1)", "sweep.json /thresholds: must be a list"},
      {R"("error_ranges_cm": [[0, 5], [30, 15]])",
       "sweep.json /error_ranges_cm/1: must have the smaller error first, is [30,15]"},
      {R"("error_ranges_cm": [[-5, 5]])", "sweep.json /error_ranges_cm/0: must not be below 0, is [-5,5]"},
      {R"("error_ranges_cm": [5])", "sweep.json /error_ranges_cm/0: must be an array of two numbers"},
      {R"("error_ranges_cm": [])", "sweep.json /error_ranges_cm: must hold at least one [low, high]"},
      {R"("error_ranges_cm": [[0, 5], [0, 5]])", "sweep.json /error_ranges_cm: has [0,5] twice"},
      {R"("trials": 0)", "sweep.json /trials: must be 1 to 1000000000000, is 0"},
      {R"("trials": -5)", "sweep.json /trials: must be an integer of 0 or more"},
      {R"("trials": 1000000000001)", "sweep.json /trials: must be 1 to 1000000000000"},
      {R"("trials": 99999999999999999999)", "sweep.json /trials: must be an integer"},
      {R"("max_iterations": 0)", "sweep.json /max_iterations: must be 1 to 20000, is 0"},
      {R"("time_repeats": 0)", "sweep.json /time_repeats: must be 1 to 1000, is 0"},
      {R"("gradients": ["backwards"])",
       "sweep.json /gradients: has \"backwards\"; known are: printed, corrected"},
      {R"("joints": ["volume", "knee"])", "sweep.json /joints: has \"knee\"; known are: centre, volume"},
      {R"("error_models": ["none"])",
       "sweep.json /error_models: has \"none\"; known are: range_signed, displacement, gaussian"},
      {R"("threshold_units": ["mm2"])", "sweep.json /threshold_units: has \"mm2\"; known are: cm2, m2"},
      {R"("starts": ["hint"])",
       "sweep.json /starts: has \"hint\"; known are: linear, squared_ranges, mean, previous"},
      {R"("stops": ["printed", "step", "printed"])", "sweep.json /stops: has \"printed\" twice"},
      {R"("dampings": [])", "sweep.json /dampings: must name at least one of: none, lm"},
      {R"("dampings": "lm")", "sweep.json /dampings: must be an array of texts"},
      {R"("search": true, "thresholds": [1])", "sweep.json /search: compares with the printed Table I"},
      {R"("methods": [])", "sweep.json /methods: is an unknown key; known are: "}};
  for (const auto& [members, message] : cases)
    EXPECT_THAT(sweep_refusal(kOneRig + ", " + members), HasSubstr(message)) << members;
}

TEST(SweepSpec, ErrorsOfARigNameItsPlaceInTheList) {
  const std::pair<const char*, const char*> cases[] = {
      {R"("heights_m": [1, 2])", "sweep.json /rigs/0/heights_m: must place 3 to 8 sensors, places 2"},
      {R"("heights_m": [1, 2, 1, 2, 1, 2, 1, 2, 1])", "must place 3 to 8 sensors, places 9"},
      {R"("sensors_m": [[0, 0, 0], [1, 0, 0], [0, 0, 0], [0, 1, 0]])",
       "sweep.json /rigs/0/sensors_m: has sensors 0 and 2 in one place"},
      {R"("sensors_m": [[0, 0, 0], [1, 1, 0], [2, 2, 0], [3, 3, 0]])",
       "sweep.json /rigs/0/sensors_m: has all sensors on one line"},
      {R"("sensors_m": [[0, 0, 0], [1, 1], [2, 2, 0]])",
       "sweep.json /rigs/0/sensors_m/1: must be a position [x, y, z] in metres"},
      {R"("sensors_m": [[0, 0, 0], [1e200, 1, 0], [0, 2, 0]])", "must stay within 10000 m of the origin"},
      {R"("heights_m": [1, 2, 3], "radius_m": 0)", "sweep.json /rigs/0/radius_m: must be greater than 0"},
      {R"("heights_m": [1, 2, 3], "sensors_m": [])", "a rig has either heights_m on a circle or sensors_m"},
      {R"("radius_m": 2)", "a rig has either heights_m on a circle or sensors_m"},
      {R"("heights_m": [1, 2, 3], "radius": 2)", "sweep.json /rigs/0/radius: is an unknown key"}};
  for (const auto& [members, message] : cases)
    EXPECT_THAT(refusal_of_rig(members), HasSubstr(message)) << members;
  EXPECT_THAT(sweep_refusal(R"("rigs": [])"), HasSubstr("sweep.json /rigs: must hold at least one rig"));
  const std::string rig = R"({"name": "a", "heights_m": [0.3, 2.3, 0.3, 2.3]})";
  EXPECT_THAT(sweep_refusal("\"rigs\": [" + rig + ", " + rig + "]"),
              HasSubstr("sweep.json /rigs/1/name: is \"a\", which an earlier rig has"));
  EXPECT_THAT(sweep_refusal("\"rigs\": [" + rig + R"(, {"name": "b", "heights_m": [0.3, 2.3, 0.3, 2.3]}])"),
              HasSubstr("sweep.json /rigs/1/name: names the same sensors as \"a\""));
}

TEST(SweepSpec, TrialsThatCannotBeCountedAreRefused) {
  EXPECT_THAT(sweep_refusal(kOneRig + R"(, "trials": 1000000000000, "joints": ["centre", "volume"],
      "error_models": ["range_signed", "displacement", "gaussian"], "threshold_units": ["cm2", "m2"],
      "stops": ["printed", "objective", "step"], "starts": ["linear", "squared_ranges", "mean", "previous"],
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

TEST(SweepPlan, NothingLeftIsAnError) {
  EXPECT_THAT(sweep_refusal(kOneRig + R"(, "gradients": ["printed"], "dampings": ["lm"])"),
              HasSubstr("sweep.json /dampings: leaves nothing to compute: each of the 2 combinations"));
  EXPECT_THAT(sweep_refusal(R"("rigs": [{"name": "flat", "heights_m": [1, 1, 1, 1]}])"),
              HasSubstr("leaves nothing to compute"));
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
      "starts": ["previous", "mean"], "curvatures": ["newton"], "stops": ["step"], "seed": 9)");
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
  const SweepSpec table1 = parse_sweep(read_json(folder / "table1.json"), "table1.json");
  EXPECT_EQ(make_sweep_plan(table1, "table1.json").readings.size(), 8u);
  EXPECT_EQ(table1.trials, 5000u);
  EXPECT_GT(table1.time_problems, 0u);
  const SweepSpec search = parse_sweep(read_json(folder / "table1_search.json"), "table1_search.json");
  EXPECT_TRUE(search.search);
  EXPECT_GE(search.rigs.size(), 6u);
  EXPECT_EQ(make_sweep_plan(search, "table1_search.json").readings.size(), 1944u);
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

TEST(StudyKind, IsNamedAmongTheKnownOnes) {
  EXPECT_EQ(study_kind(parse_json(R"({"kind": "threshold_sweep"})", "s.json"), "s.json"),
            StudyKind::threshold_sweep);
  EXPECT_THAT(
      message_of([] { study_kind(parse_json(R"({"kind": "speed"})", "s.json"), "s.json"); }),
      HasSubstr("s.json /kind: is \"speed\", which is unknown; known are: accuracy, threshold_sweep"));
}

}  // namespace
}  // namespace trilat
