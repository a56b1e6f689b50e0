// SPDX-License-Identifier: MIT
#include "pipeline/calibration_study/calibration_study.h"

#include <array>
#include <cmath>
#include <map>
#include <mutex>
#include <set>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/base/units.h"
#include "datasets/results/results_file.h"
#include "pipeline/calibration_study/calibration_findings.h"
#include "pipeline/calibration_study/calibration_summary.h"
#include "pipeline/calibration_study/rig_trials.h"
#include "pipeline/calibration_study/simulated_run.h"
#include "pipeline/calibration_study/wand_samples.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::AllOf;
using testing::Each;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

CalibrationSpec calibration_spec_of(const std::string& members) {
  const std::string text =
      R"({"format": "trilat.study", "version": 1, "kind": "calibration", "name": "test")" + members + "}";
  return parse_calibration_spec(parse_json(text, "study.json"), "study.json");
}

// Columns without a depth count for nothing.
TEST(ColumnMeans, AreOverTheColumnsThatHadADepth) {
  std::vector<double> by_column(512, 0.02);
  std::fill(by_column.begin() + 150, by_column.begin() + 351, 0.01);
  by_column[0] = by_column[200] = by_column[511] = NAN;
  const ColumnMeans means = column_means(by_column);
  EXPECT_NEAR(means.left, 0.02, 1e-12);
  EXPECT_NEAR(means.middle, 0.01, 1e-12);
  EXPECT_NEAR(means.right, 0.02, 1e-12);
  EXPECT_NEAR(means.edge_to_middle(), 2.0, 1e-9);
}

// 1 to 5 mm: the mean is 3, the squares about it add up to 10; quantiles interpolate between neighbours.
TEST(ErrorSpread, MeanDeviationAndQuantilesByPencil) {
  std::vector<ClusteredError> errors;
  for (std::size_t i : {4u, 0u, 2u, 1u, 3u}) errors.push_back({0, 1e-3 * static_cast<double>(i + 1)});
  errors.push_back({1, ErrorSpread::kNone});
  const ErrorSpread spread = spread_of(errors);
  EXPECT_EQ(spread.asked, 6u);
  EXPECT_EQ(spread.answered, 5u);
  EXPECT_NEAR(spread.mean_m, 0.003, 1e-15);
  EXPECT_NEAR(spread.sd_m, std::sqrt(10e-6 / 4.0), 1e-15);
  EXPECT_NEAR(spread.median_m, 0.003, 1e-15);
  EXPECT_NEAR(spread.p95_m, 0.0048, 1e-15);
  EXPECT_NEAR(spread.max_m, 0.005, 1e-15);
  EXPECT_TRUE(std::isnan(spread.mean_low_m));
}

TEST(ErrorSpread, NothingAndOneErrorHaveNoNumbersTheyCannotHave) {
  const ErrorSpread nothing = spread_of({}), none = spread_of({{0, ErrorSpread::kNone}});
  EXPECT_EQ(nothing.asked, 0u);
  EXPECT_EQ(none.asked, 1u);
  for (const ErrorSpread& spread : {nothing, none}) {
    EXPECT_EQ(spread.answered, 0u);
    EXPECT_TRUE(std::isnan(spread.mean_m) && std::isnan(spread.sd_m) && std::isnan(spread.max_m));
  }
  const ErrorSpread one = spread_of({{0, 0.25}});
  EXPECT_EQ(one.mean_m, 0.25);
  EXPECT_EQ(one.p95_m, 0.25);
  EXPECT_TRUE(std::isnan(one.sd_m));
}

TEST(ErrorSpread, AnIntervalIsBetweenClusters) {
  const auto clusters = [](std::size_t count) {
    std::vector<ClusteredError> errors;
    for (std::size_t c = 0; c < count; ++c)
      for (int i = 0; i < 100; ++i) errors.push_back({c, 1e-3 * static_cast<double>(c + 1)});
    return errors;
  };
  EXPECT_TRUE(std::isnan(spread_of(clusters(1)).mean_low_m));
  // 1 to 4 mm: Student's t of three degrees, and a standard error of sqrt(5 / 3) / 2 mm
  const ErrorSpread spread = spread_of(clusters(4));
  EXPECT_NEAR(spread.mean_low_m, 0.0025 - 3.182446 * 0.001 * std::sqrt(5.0 / 3.0) / 2.0, 1e-8);
  EXPECT_NEAR(spread.mean_high_m, 0.0025 + 3.182446 * 0.001 * std::sqrt(5.0 / 3.0) / 2.0, 1e-8);
}

// Sigmas of 1, 2, 1 rad and 1, 3, 2 m: errors of 1, 1, 2 and 0, 1, 2 of them, of which two are beyond 1.96.
TEST(PoseMisfit, ErrorsOverStatedSigmasByPencil) {
  Eigen::Matrix<double, 6, 1> error, sigmas;
  error << 1.0, 2.0, 2.0, 0.0, 3.0, 4.0;
  sigmas << 1.0, 2.0, 1.0, 1.0, 3.0, 2.0;
  const PoseMisfit misfit = misfit_of(error, sigmas.cwiseAbs2().asDiagonal());
  EXPECT_DOUBLE_EQ(misfit.rotation_z2, 2.0);
  EXPECT_DOUBLE_EQ(misfit.position_z2, 5.0 / 3.0);
  EXPECT_DOUBLE_EQ(misfit.mahalanobis2, 11.0);
  EXPECT_EQ(misfit.covered, 4u);
  EXPECT_EQ(misfit.asked, 6u);
}

// Errors that go together as stated are less far off than each by itself says: (1 + 1 - 2 / 2) / (1 - 1 / 4).
TEST(PoseMisfit, TheMahalanobisDistanceKnowsThatTurnAndPlaceGoTogether) {
  Eigen::Matrix<double, 6, 1> error;
  error << 1.0, 0.0, 0.0, 1.0, 0.0, 0.0;
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Identity();
  covariance(0, 3) = covariance(3, 0) = 0.5;
  EXPECT_NEAR(misfit_of(error, covariance).mahalanobis2, 4.0 / 3.0, 1e-12);
  EXPECT_DOUBLE_EQ(misfit_of(error, covariance).rotation_z2, 1.0 / 3.0);
}

CalibrationSpec tiny_spec() {
  return calibration_spec_of(
      R"(, "units": 1, "samples": 2, "near_samples": 1, "frames": 1, "distortion_units": 1,
      "distortion_frames": 4, "runs": 1, "positions": 6, "position_frames": 1, "bodies_s": 1,
      "bodies_instants": 6)");
}

CalibrationSpec wand_only_spec(const std::string& members) {
  return calibration_spec_of(members +
                             R"(, "near_samples": 0, "frames": 1, "distortion_units": 0, "runs": 0)");
}

// A flat offset of the depths is along the ray of a ball on the central line, so there both errors are one.
TEST(CalibrationStudy, TheErrorOfTheDistanceIsThatAlongTheRayOnly) {
  const ScratchFolder folder;
  run_study(calibration_study(wand_only_spec(
                R"(, "units": 4, "samples": 3, "distances_m": [1.2, 1.8], "largest_angle_deg": 0)")),
            folder / "axis", {});
  const CalibrationSummary axis = read_results<CalibrationSummary>(folder / "axis");
  std::size_t compared = 0;
  for (const WandSample& sample : axis.wand_samples) {
    if (axis.wand[sample.row].method != "ours" || axis.wand[sample.row].scene != "far wall") continue;
    EXPECT_LE(sample.distance_error_m, sample.error_m);
    EXPECT_NEAR(sample.distance_error_m, sample.error_m, 0.002);
    ++compared;
  }
  EXPECT_EQ(compared, 12u);
  for (const WandRow& row : axis.wand) {
    EXPECT_EQ(row.recommended_distance.answered, row.recommended.answered) << row.method;
    EXPECT_FALSE(row.recommended_distance.mean_m > row.recommended.mean_m) << row.method;
  }
}

// Nearer than 0.8 m, where the paper sees more error, lies a tenth of the span of distances.
TEST(CalibrationStudy, EveryUnitHasSamplesInEachZoneThatThePaperJudges) {
  const ScratchFolder folder;
  run_study(calibration_study(wand_only_spec(R"(, "units": 4, "samples": 40)")), folder / "zones", {});
  std::map<std::uint64_t, std::array<int, 4>> zones;  // of a unit: too near, within, too far, too wide
  for (const WandSample& sample : read_results<CalibrationSummary>(folder / "zones").wand_samples) {
    if (sample.row != 0) continue;
    auto& [near, within, far, wide] = zones[sample.unit];
    const double deg = sample.angle_rad * kDegreesPerRad;
    near += sample.distance_m >= 0.5 && sample.distance_m < 0.8;
    within += sample.distance_m >= 0.8 && sample.distance_m <= 3.0 && deg < 26.0;
    far += sample.distance_m > 3.0;
    wide += deg >= 26.0;
  }
  EXPECT_THAT(zones, SizeIs(4));
  for (const auto& [unit, count] : zones) {
    // 0.9 and 1.5 parts of 4.9, each sample in a part of its own: 7.3 and 12.2 of 40, and no unit has fewer
    // than
    EXPECT_GE(count[0], 6) << unit;
    EXPECT_GE(count[2], 12) << unit;
    EXPECT_GE(count[1], 9) << unit;
    EXPECT_GE(count[3], 4) << unit;
  }
}

// Level, seen by all and without depth errors of the units the corrected equations have nothing to be wrong
// about but what noise leaves: the frame they are scored in is the one they give.
TEST(CalibrationStudy, TheFirstThreePlacesAreLevelAndSeenByEverySensor) {
  const CalibrationSpec spec = tiny_spec();
  const auto rig = true_rig(spec);
  for (std::uint64_t run = 0; run < 3; ++run) {
    const SimulatedRun simulated = simulate_run(spec, rig, run, {});
    ASSERT_GE(simulated.views.positions.size(), 3u);
    for (std::size_t p = 0; p < 3; ++p) EXPECT_THAT(simulated.views.positions[p].seen, SizeIs(rig.size()));
    EXPECT_DOUBLE_EQ(simulated.position_in_world_m[0].y(), simulated.position_in_world_m[1].y());
    const Eigen::Vector3d up = simulated.wand_from_world.rotation * Eigen::Vector3d::UnitY();
    EXPECT_NEAR(up.y(), 1.0, 1e-12);
  }
}

}  // namespace
}  // namespace trilat
