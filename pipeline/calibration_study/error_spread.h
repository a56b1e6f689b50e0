// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/calibration_study/calibration_summary.h"

namespace trilat {

// How a set of errors is spread, in metres. NaN where nothing answered.
struct ErrorSpread {
  std::uint64_t asked = 0;
  std::uint64_t answered = 0;
  double mean_m = kNotMeasured;
  double sd_m = kNotMeasured;
  double median_m = kNotMeasured;
  double p95_m = kNotMeasured;
  double max_m = kNotMeasured;
  // 95 % interval of the mean, by Student's t over clusters, not over samples.
  double mean_low_m = kNotMeasured, mean_high_m = kNotMeasured;
};

// One error and the cluster it belongs to: errors of one sensor have causes in common.
struct ClusteredError {
  std::size_t cluster = 0;
  double error_m = kNotMeasured;  // NaN: no answer
};

ErrorSpread spread_of(const std::vector<ClusteredError>& errors);

// "1.17 cm (95 % interval 0.68 to 1.69 cm)"; says so when there is no answer or no interval.
std::string mean_text(const ErrorSpread& spread);

// Means over the columns of a row that had a depth: the two outer parts, where the paper finds more error
// (columns 0 to 149 and 351 to the last), and between.
struct ColumnMeans {
  double left = kNotMeasured, middle = kNotMeasured, right = kNotMeasured;
  double edge = kNotMeasured;  // of all columns of both outer parts

  double edge_to_middle() const { return edge / middle; }  // NaN without a middle
};
ColumnMeans column_means(const std::vector<double>& by_column);

}  // namespace trilat
