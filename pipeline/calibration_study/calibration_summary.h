// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "datasets/base/described.h"
#include "datasets/results/claims.h"
#include "datasets/results/results_file.h"

namespace trilat {

// How a set of errors is spread. NaN where nothing answered.
struct ErrorSpread {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::uint64_t asked = 0;
  std::uint64_t answered = 0;
  double mean_m = kNone;
  double sd_m = kNone;
  double median_m = kNone;
  double p95_m = kNone;
  double max_m = kNone;
  // 95 % interval of the mean, by Student's t over units (each with its own depth offset), not over samples.
  double mean_low_m = kNone, mean_high_m = kNone;

  TRILAT_FIELDS(asked, answered, mean_m, sd_m, median_m, p95_m, max_m, mean_low_m, mean_high_m)
};

// One way to find the wand, over all simulated samples of one scene.
struct WandRow {
  std::string method;       // "as printed", "ours", …
  std::string scene;        // "far wall": ball alone, wall at 7 m; "room": with floor, walls and the person
  ErrorSpread all;          // over the whole span of distance and angle
  ErrorSpread recommended;  // 0.8 to 3 m and below 26 degrees
  ErrorSpread near;         // nearer than 0.5 m
  std::map<std::string, std::uint64_t> statuses;  // of `all`
  // Errors of the distance from sensor to ball centre alone, in the recommended range: a laser meter measures
  // it.
  ErrorSpread recommended_distance = {};

  TRILAT_FIELDS(method, scene, all, recommended, near, statuses, recommended_distance)
};

// One sample of the figure: error against distance and angle.
struct WandSample {
  std::size_t row = 0;  // of which WandRow
  std::uint64_t unit = 0;
  double distance_m = 0.0;
  double angle_rad = 0.0;
  double error_m = ErrorSpread::kNone;           // in three dimensions; NaN: no answer
  double distance_error_m = ErrorSpread::kNone;  // |measured - true| distance sensor - ball centre

  static constexpr bool as_list = true;
  TRILAT_FIELDS(row, unit, distance_m, angle_rad, error_m, distance_error_m)
};

// A flat wall, per column of the image's middle row; mean absolute values over all frames.
struct DistortionCurve {
  double wall_m = 0.0;
  std::uint64_t frames = 0;
  std::uint64_t unit = 0;
  double unit_offset_m = 0.0;         // what the simulated unit adds to every depth
  std::vector<std::uint64_t> valid;   // frames in which the column had a depth
  std::vector<double> depth_error_m;  // of the depth
  std::vector<double>
      depth_residual_m;                 // of the depth less the row's mean error: without the constant offset
  std::vector<double> printed_error_m;  // sideways, eq. 4 as printed (E2)
  std::vector<double> lens_error_m;     // sideways, lens model

  TRILAT_FIELDS(wall_m, frames, unit, unit_offset_m, valid, depth_error_m, depth_residual_m, printed_error_m,
                lens_error_m)
  void check(const JsonObject& object) const {
    for (const auto* curve : {&depth_error_m, &depth_residual_m, &printed_error_m, &lens_error_m})
      if (curve->size() != valid.size()) object.refuse("valid", "must be as long as the curves");
  }
};

// One way to calibrate a rig, over simulated runs.
struct RigRow {
  std::string method;  // "two positions, corrected", "wand", …
  std::uint64_t runs = 0;
  std::uint64_t failed_runs = 0;  // no pose for at least one sensor
  ErrorSpread position;           // over sensors of all runs; not answered: no pose
  double rotation_mean_rad = ErrorSpread::kNone;
  double rotation_max_rad = ErrorSpread::kNone;
  double within_limits_share = ErrorSpread::kNone;  // of sensors: 5 mm and 0.2 degrees
  double coverage_share = ErrorSpread::kNone;  // of stated 95 % intervals, an axis each, that hold the truth
  double coverage_low = ErrorSpread::kNone, coverage_high = ErrorSpread::kNone;  // 95 % interval over runs
  // Errors over stated standard deviations, root mean square over axes: 1 where what is stated is right.
  double position_z_rms = ErrorSpread::kNone, rotation_z_rms = ErrorSpread::kNone;
  double mahalanobis2_mean = ErrorSpread::kNone;  // squared, of a pose's six numbers: 6 where it is right
  double reduced_chi2_mean = ErrorSpread::kNone;  // over runs

  TRILAT_FIELDS(method, runs, failed_runs, position, rotation_mean_rad, rotation_max_rad, within_limits_share,
                coverage_share, coverage_low, coverage_high, position_z_rms, rotation_z_rms,
                mahalanobis2_mean, reduced_chi2_mean)
};

// summary.json of a study of kind "calibration". All of it is simulated.
struct CalibrationSummary {
  static constexpr StudyKind kKind = StudyKind::calibration;
  std::string study;
  std::uint64_t seed = 0;
  std::uint64_t samples = 0, units = 0, frames = 0;  // samples a unit, frames a position
  double ball_radius_m = 0.0;
  std::vector<WandRow> wand;
  std::vector<WandSample> wand_samples;
  std::vector<DistortionCurve> distortion;
  std::uint64_t positions = 0;  // of the wand in a run
  std::vector<RigRow> rigs;
  std::vector<ClaimNumber> claims;  // of the paper, that the study bears on

  static void fields(auto& self, auto&& field) {
    TRILAT_EACH(study)
    field("simulated", true);
    TRILAT_EACH(seed, samples, units, frames, ball_radius_m, positions, wand, wand_samples, distortion, rigs,
                claims)
  }
};

}  // namespace trilat
