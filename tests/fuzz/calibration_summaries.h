// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "datasets/base/units.h"
#include "pipeline/calibration_study/calibration_summary.h"

namespace trilat {

inline ErrorSpread spread_around(double mean_m, std::uint64_t answered, std::uint64_t asked) {
  ErrorSpread spread;
  spread.asked = asked;
  spread.answered = answered;
  spread.mean_m = mean_m;
  spread.sd_m = mean_m / 2;
  spread.median_m = mean_m;
  spread.p95_m = 2 * mean_m;
  spread.max_m = 3 * mean_m;
  spread.mean_low_m = 0.5 * mean_m;
  spread.mean_high_m = 1.5 * mean_m;
  return spread;
}

inline WandRow wand_row_of(const std::string& method, double mean_m) {
  return {method,
          "far wall",
          spread_around(2 * mean_m, 6, 8),
          spread_around(mean_m, 3, 4),
          spread_around(mean_m, 1, 5),
          {{"found", 6}, {"no_wand", 2}},
          spread_around(0.4 * mean_m, 3, 4)};
}

// 512 columns: 20 mm of depth error outside of columns 150 to 350, 10 mm inside, half of the frames valid.
inline DistortionCurve hand_made_curve() {
  DistortionCurve curve;
  curve.wall_m = 2.0;
  curve.frames = 100;
  curve.unit_offset_m = -0.008;
  for (int c = 0; c < 512; ++c) {
    const bool middle = c >= 150 && c <= 350;
    curve.valid.push_back(50);
    curve.depth_error_m.push_back(middle ? 0.01 : 0.02);
    curve.depth_residual_m.push_back(middle ? 0.001 : 0.004);
    curve.printed_error_m.push_back(c == 0 ? 0.08 : 0.03);
    curve.lens_error_m.push_back(0.006);
  }
  return curve;
}

inline CalibrationSummary hand_made_calibration() {
  CalibrationSummary s;
  s.study = "hand made";
  s.samples = 8;
  s.units = 4;
  s.frames = 5;
  s.ball_radius_m = 0.075;
  s.positions = 50;
  s.wand = {wand_row_of("corrected, but E2 as printed", 0.06), wand_row_of("corrected", 0.04),
            wand_row_of("ours", 0.02)};
  s.wand_samples = {{2, 0, 0.5, 10 * kRadPerDegree, 0.10, 0.05},
                    {2, 0, 0.8, 20 * kRadPerDegree, 0.02, 0.01},
                    {2, 1, 1.2, 20 * kRadPerDegree, 0.04, 0.03},
                    {2, 1, 4.5, 30 * kRadPerDegree, ErrorSpread::kNone},
                    {1, 0, 0.5, 10 * kRadPerDegree, 0.30, 0.20}};
  s.distortion = {hand_made_curve()};
  RigRow wand{"wand",
              3,
              1,
              spread_around(0.005, 10, 12),
              0.5 * kRadPerDegree,
              1.5 * kRadPerDegree,
              0.75,
              0.9,
              0.85,
              0.95,
              1.04,
              0.97,
              6.2,
              1.03};
  s.rigs = {wand};
  return s;
}

}  // namespace trilat
