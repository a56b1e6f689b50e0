// SPDX-License-Identifier: MIT
#include "datasets/results/studies/calibration_summary.h"

#include <cmath>
#include <functional>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/results/results_file.h"
#include "datasets/results/studies/sweep_summary.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kNone = ErrorSpread::kNone;

CalibrationSummary full_summary() {
  CalibrationSummary s;
  s.study = "calibration";
  s.seed = 7;
  s.samples = 3;
  s.units = 2;
  s.frames = 5;
  s.ball_radius_m = 0.075;
  s.positions = 50;
  const ErrorSpread spread{4, 3, 0.1 + 0.2, 1.0 / 3.0, 0.3, 0.4, 0.5, 0.25, 0.35};
  s.wand = {{"as printed", "free", spread, {}, {}, {{"found", 3}, {"no_wand", 1}}},
            {"ours", "room", {}, spread, spread, {}, {4, 2, 0.007}}};
  s.wand_samples = {{0, 1, 1.5, 0.25, 0.012, 0.004}, {1, 0, 2.5, 0.5, kNone, kNone}};
  s.distortion = {
      {2.0, 1000, 1, -0.013, {1000, 0}, {0.01, kNone}, {0.001, kNone}, {0.2, kNone}, {0.003, 0.0}}};
  s.rigs = {{"wand", 6, 1, spread, 0.001, 0.002, 0.875, 0.95, 0.9, kNone, 1.1, 0.9, 6.5, 1.02}};
  s.effect = {{"exact", 0.0, 0.025, "nonlinear", 200, 199, 0.03, 0.029, 0.98, kNone}};
  return s;
}

TEST(CalibrationSummary, WhatIsWrittenIsReadBackAndNaNStaysNaN) {
  const ScratchFolder folder;
  write_calibration_summary(folder.path(), full_summary());
  EXPECT_EQ(results_kind(folder.path()), StudyKind::calibration);
  const CalibrationSummary read = read_calibration_summary(folder.path());
  EXPECT_EQ(read.study, "calibration");
  EXPECT_EQ(read.seed, 7u);
  EXPECT_EQ(read.positions, 50u);
  EXPECT_EQ(read.ball_radius_m, 0.075);
  ASSERT_EQ(read.wand.size(), 2u);
  EXPECT_EQ(read.wand[0].all.mean_m, 0.1 + 0.2);
  EXPECT_EQ(read.wand[0].all.mean_high_m, 0.35);
  EXPECT_TRUE(std::isnan(read.wand[0].recommended.p95_m));
  EXPECT_EQ(read.wand[0].statuses.at("no_wand"), 1u);
  EXPECT_EQ(read.wand[1].near.answered, 3u);
  ASSERT_EQ(read.wand_samples.size(), 2u);
  EXPECT_EQ(read.wand_samples[0].error_m, 0.012);
  EXPECT_EQ(read.wand_samples[0].distance_error_m, 0.004);
  EXPECT_EQ(read.wand[1].recommended_distance.answered, 2u);
  EXPECT_EQ(read.wand[1].recommended_distance.mean_m, 0.007);
  EXPECT_TRUE(std::isnan(read.wand_samples[1].error_m));
  EXPECT_TRUE(std::isnan(read.wand_samples[1].distance_error_m));
  EXPECT_EQ(read.wand_samples[1].row, 1u);
  ASSERT_EQ(read.distortion.size(), 1u);
  EXPECT_THAT(read.distortion[0].valid, ElementsAre(1000u, 0u));
  EXPECT_EQ(read.distortion[0].unit_offset_m, -0.013);
  EXPECT_EQ(read.distortion[0].printed_error_m[0], 0.2);
  EXPECT_TRUE(std::isnan(read.distortion[0].depth_residual_m[1]));
  ASSERT_EQ(read.rigs.size(), 1u);
  EXPECT_EQ(read.rigs[0].failed_runs, 1u);
  EXPECT_EQ(read.rigs[0].coverage_share, 0.95);
  EXPECT_TRUE(std::isnan(read.rigs[0].coverage_high));
  EXPECT_EQ(read.rigs[0].position_z_rms, 1.1);
  EXPECT_EQ(read.rigs[0].rotation_z_rms, 0.9);
  EXPECT_EQ(read.rigs[0].mahalanobis2_mean, 6.5);
  EXPECT_EQ(read.rigs[0].reduced_chi2_mean, 1.02);
  ASSERT_EQ(read.effect.size(), 1u);
  EXPECT_EQ(read.effect[0].answered, 199u);
  EXPECT_TRUE(std::isnan(read.effect[0].ratio_high));
  const std::string first = read_file(folder / "summary.json");
  write_calibration_summary(folder.path(), read);
  EXPECT_EQ(read_file(folder / "summary.json"), first);
}

TEST(CalibrationSummary, ResultsOfAnotherKindAreRefused) {
  const ScratchFolder folder;
  write_sweep_summary(folder.path(), SweepSummary{});
  EXPECT_THAT(message_of([&] { read_calibration_summary(folder.path()); }),
              HasSubstr("/kind: is \"threshold_sweep\"; results of kind \"calibration\" are needed here"));
  write_calibration_summary(folder.path(), full_summary());
  EXPECT_THAT(message_of([&] { read_sweep_summary(folder.path()); }), HasSubstr("/kind: is \"calibration\""));
}

class SpoiltSummary : public testing::Test {
 protected:
  std::string refusal(const std::function<void(Json&)>& spoil) {
    write_calibration_summary(folder_.path(), full_summary());
    Json json = read_json(folder_ / "summary.json");
    spoil(json);
    write_file(folder_ / "summary.json", json_text(json, -1));
    return message_of([&] { read_calibration_summary(folder_.path()); });
  }
  ScratchFolder folder_;
};

TEST_F(SpoiltSummary, SamplesOfRowsThatAreNotThereAreRefused) {
  EXPECT_EQ(refusal([](Json&) {}), "no error");
  for (const char* sample :
       {"[2, 0, 1.0, 0.1, null, null]", "[-1, 0, 1.0, 0.1, null, null]", "[0, 0, 1.0, 0.1, 0.2]",
        "[0, 0, null, 0.1, 0.2, 0.2]", "[0, 0.5, 1.0, 0.1, 0.2, 0.2]", "{}"})
    EXPECT_THAT(refusal([&](Json& json) { json["wand_samples"][1] = parse_json(sample, "sample"); }),
                HasSubstr("summary.json /wand_samples: must hold [row, unit, distance_m, angle_rad, error_m, "
                          "distance_error_m]"))
        << sample;
}

TEST_F(SpoiltSummary, CurvesOfUnequalLengthAreRefused) {
  for (const char* curve : {"depth_error_m", "depth_residual_m", "printed_error_m", "lens_error_m"})
    EXPECT_THAT(refusal([&](Json& json) { json["distortion"][0][curve].erase(1); }),
                HasSubstr("/distortion/0/valid: must be as long as the curves"))
        << curve;
}

TEST_F(SpoiltSummary, CountsThatAreNoneAreRefused) {
  for (const char* count : {"null", "-1", "1001", "1e300"})
    EXPECT_THAT(refusal([&](Json& json) { json["distortion"][0]["valid"][1] = parse_json(count, "count"); }),
                HasSubstr("/distortion/0/valid: must hold counts from 0 to the number of frames"))
        << count;
}

TEST_F(SpoiltSummary, KeysNobodyKnowsAndTextInPlaceOfNumbersAreNamed) {
  EXPECT_THAT(refusal([](Json& json) { json["rigs"][0]["luck"] = 1; }), HasSubstr("/rigs/0/luck"));
  EXPECT_THAT(refusal([](Json& json) { json["wand"][1]["near"]["mean_m"] = "small"; }),
              HasSubstr("/wand/1/near/mean_m"));
  EXPECT_THAT(refusal([](Json& json) { json["distortion"][0]["lens_error_m"][0] = "small"; }),
              HasSubstr("/distortion/0/lens_error_m: must hold numbers and nulls only"));
}

}  // namespace
}  // namespace trilat
