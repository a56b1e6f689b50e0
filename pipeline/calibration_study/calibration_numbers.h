// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "datasets/paper/printed_tables.h"
#include "datasets/results/figure.h"
#include "datasets/results/table.h"
#include "pipeline/calibration_study/calibration_summary.h"

namespace trilat {

// How a set of errors is spread, in metres. NaN where nothing answered.
struct ErrorStatistics {
  std::uint64_t asked = 0;
  std::uint64_t answered = 0;
  double mean_m = kNaN;
  double sd_m = kNaN;
  double median_m = kNaN;
  double p95_m = kNaN;
  double max_m = kNaN;
  // 95 % interval of the mean, by Student's t over clusters, not over samples.
  double mean_low_m = kNaN, mean_high_m = kNaN;
  std::uint64_t clusters = 0;  // with an answer
};

// One error and the cluster it belongs to: errors of one sensor have causes in common.
struct ClusteredError {
  std::size_t cluster = 0;
  double error_m = kNaN;  // NaN: no answer
};

ErrorStatistics statistics_of(const std::vector<ClusteredError>& errors);

// Means over the columns of a row that had a depth: the two outer parts, where the paper finds more error
// (columns 0 to 149 and 351 to the last), and between.
struct ColumnMeans {
  double left = kNaN, middle = kNaN, right = kNaN;
  double edge = kNaN;  // of all columns of both outer parts
};
ColumnMeans column_means(const std::vector<double>& by_column);

// Zones of the ball: the paper's recommended range; everywhere; nearer than a Kinect is said to see.
inline constexpr const char *kInside = "inside", *kAllPlaces = "all", *kNear = "near";
// The ways to find the ball that bins and figures show.
inline constexpr std::array kMainWandMethods{"ours", "corrected", "corrected by the mid-range"};

// Bins of the ball's distance and angle, the outer ones open.
struct PlaceBin {
  const char* of;  // "distance", "angle"
  double from, to;
  bool is_first, is_last;
  std::string name() const;  // "distance 0.5 to 0.8 m", "angle from 26 degrees"
};
const std::vector<PlaceBin>& place_bins();

// The numbers of a study, as CalibrationSummary has them. Zones beside the recommended range, whose errors
// are compared with those in it: "nearer" and "farther" at its angles, "aside" at its distances. Statistics
// of a wall: "distance" (of the fitted plane along the lens' axis), "stated" and "noise" (of a pixel's
// depth); of "residual" and "sideways" the means over the left, middle and right columns, both outer parts
// (edge), and the max.
Numbers calibration_numbers(const CalibrationRecordings& recordings);

inline const PrintedCalibration& paper_calibration() {
  static const PrintedCalibration printed = printed_calibration();
  return printed;
}

inline std::string source_text(bool simulated) { return simulated ? "simulated" : "recorded"; }

// Tables of a calibration study, beside the paper's statements; a part that was not run gives none.
StoredTables calibration_tables(const CalibrationSummary& summary, const CalibrationRecordings& recordings);

// The paper's two calibration figures: error against distance and angle, and depth error against image
// column. Each needs its recordings.
std::vector<Figure> calibration_figures(bool simulated, const CalibrationRecordings& recordings);

}  // namespace trilat
