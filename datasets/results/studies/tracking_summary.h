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

// How one sensor's views of one joint group fared under one rule, over all takes of a condition. `rule` is
// "inferred" (the tracker's own word), "crossed, printed", "crossed, corrected", "hidden in depth", or
// "method: " and the name of a method, whose rejections among the sensors it may use are counted then. What
// is truly hidden only a simulation knows.
struct ViewRow {
  std::string condition, sensor, group, rule;
  std::uint64_t views = 0;     // instants and joints that the sensor gives a position for
  std::uint64_t rejected = 0;  // of them
  bool truth_known = false;    // the next two are counts of something
  std::uint64_t hidden = 0;    // truly
  std::uint64_t rightly = 0;   // rejected and truly hidden

  static void fields(auto& self, auto&& field) {
    TRILAT_EACH(condition, sensor, group, rule, views, rejected)
    if (field.has("hidden", self.truth_known)) {
      TRILAT_EACH(hidden, rightly)
    }
  }
};

// Left and right exchanged by one sensor: what was found, and what a simulation knows.
struct ExchangeRow {
  std::string condition, sensor;
  std::uint64_t instants = 0;  // with a body
  std::uint64_t found = 0;     // of them, said to be exchanged
  std::uint64_t stretches = 0;
  bool truth_known = false;
  std::uint64_t exchanged = 0;        // truly
  std::uint64_t rightly = 0;          // found and truly exchanged
  std::uint64_t true_stretches = 0;   // runs of truly exchanged bodies
  std::uint64_t stretches_found = 0;  // of them, found in at least 95 % of their instants

  static void fields(auto& self, auto&& field) {
    TRILAT_EACH(condition, sensor, instants, found, stretches)
    if (field.has("exchanged", self.truth_known)) {
      TRILAT_EACH(exchanged, rightly, true_stretches, stretches_found)
    }
  }
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

// How far the ranges of one joint group are off, over all sensors and takes of a condition: what
// trilateration has to work with.
struct RangeRow {
  std::string condition, group;
  std::uint64_t n = 0;
  double mean_error_m = kNoNumber;  // range - true distance
  double rms_error_m = kNoNumber;

  TRILAT_FIELDS(condition, group, n, mean_error_m, rms_error_m)
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
  std::vector<RangeRow> ranges = {};
  std::vector<RayRow> rays = {};
  std::vector<CorrectionRow> corrections = {};  // of studies in which a method asks
  std::vector<PredictionRow> predictions = {};  // of studies that leave sensors out

  TRILAT_FIELDS(study, simulated, repaired, views, exchanges, clocks, ranges, rays, corrections, predictions)
};

}  // namespace trilat
