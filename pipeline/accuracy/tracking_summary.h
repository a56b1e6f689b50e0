// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/base/described.h"
#include "datasets/base/strict_json.h"
#include "datasets/results/results_file.h"
#include "datasets/results/summary.h"

namespace trilat {

// How many of one sensor's views of one joint group one rule rejects, over all takes of a condition. `rule`
// is "inferred" (the tracker's own word), "crossed, printed", "crossed, corrected", or "method: " and the
// name of a method, whose rejections among the sensors it may use are counted then.
struct ViewRow {
  std::string condition, sensor, group, rule;
  std::uint64_t views = 0;     // instants and joints that the sensor gives a position for
  std::uint64_t rejected = 0;  // of them

  TRILAT_FIELDS(condition, sensor, group, rule, views, rejected)
};

// Exchanges of left and right by one sensor that were found.
struct ExchangeRow {
  std::string condition, sensor;
  std::uint64_t instants = 0;  // with a body
  std::uint64_t found = 0;     // of them
  std::uint64_t stretches = 0;

  TRILAT_FIELDS(condition, sensor, instants, found, stretches)
};

// The offset between mocap and sensors that the motion of one take shows: mocap time = stated + offset. It
// contains the trackers' lag.
struct ClockRow {
  std::string take;
  std::string status;
  double offset_s = kNoNumber, low_s = kNoNumber, high_s = kNoNumber;  // 95 %
  double drift_ppm = kNoNumber, drift_sigma_ppm = kNoNumber;
  double peak = kNoNumber, second = kNoNumber;  // correlation of speeds; the next peak as a share of it
  bool applied = false;

  TRILAT_FIELDS(take, status, offset_s, low_s, high_s, drift_ppm, drift_sigma_ppm, peak, second, applied)
};

// By how much the sensors of one take disagree along their rays and across, without what all sensors have in
// common. `problem` says why there are no numbers.
struct RayRow {
  std::string take;
  std::uint64_t rows = 0;  // instants of single joints
  std::string problem = {};
  double range_m = kNoNumber, bearing_m = kNoNumber;                        // standard deviations
  double ratio = kNoNumber, ratio_low = kNoNumber, ratio_high = kNoNumber;  // range / bearing, 95 %

  TRILAT_FIELDS(take, rows, problem, range_m, bearing_m, ratio, ratio_low, ratio_high)
};

// What one take shows of how a sensor stands and measures beside its calibration: how far it is turned and
// shifted, and by how much its ranges are too long, with 95 % intervals. `problem` says why there are no
// numbers.
struct CorrectionRow {
  std::string take, sensor;
  std::string problem = {};
  double turned_rad = kNoNumber, turned_low_rad = kNoNumber, turned_high_rad = kNoNumber;
  double shifted_m = kNoNumber, shifted_low_m = kNoNumber, shifted_high_m = kNoNumber;
  double too_long_m = kNoNumber, too_long_low_m = kNoNumber, too_long_high_m = kNoNumber;
  double stated_turn_rad = kNoNumber, stated_shift_m = kNoNumber;  // standard deviations of the calibration

  TRILAT_FIELDS(take, sensor, problem, turned_rad, turned_low_rad, turned_high_rad, shifted_m, shifted_low_m,
                shifted_high_m, too_long_m, too_long_low_m, too_long_high_m, stated_turn_rad, stated_shift_m)
};

// How well one method predicts what a sensor sees from the others, over every sensor of the rig left out in
// turn: mean distances along its ray and across, and the mean with its sign along the ray; how much its bones
// change their lengths in a take (standard deviation), and the mean jerk of its joints. 95 % intervals with
// participants as clusters. What all sensors have in common is in none of these numbers.
struct PredictionRow {
  std::string condition, method;
  std::uint64_t n = 0;
  Estimate range_m = {}, bearing_m = {};
  Estimate mean_range_m = {};  // above 0: farther than seen
  Estimate bone_m = {}, jerk_m_s3 = {};

  TRILAT_FIELDS(condition, method, n, range_m, bearing_m, mean_range_m, bone_m, jerk_m_s3)
};

// tracking.json, beside an accuracy study's summary.json.
struct TrackingSummary {
  static constexpr const char *kFile = "tracking.json", *kFormat = "trilat.tracking";
  std::string study;
  bool simulated = false;
  bool repaired = false;  // exchanges that were found were undone
  std::vector<ViewRow> views;
  std::vector<ExchangeRow> exchanges;
  std::vector<ClockRow> clocks;
  std::vector<RayRow> rays = {};
  std::vector<CorrectionRow> corrections = {};  // of studies in which a method asks
  std::vector<PredictionRow> predictions = {};  // of studies that leave sensors out

  TRILAT_FIELDS(study, simulated, repaired, views, exchanges, clocks, rays, corrections, predictions)
};

}  // namespace trilat
