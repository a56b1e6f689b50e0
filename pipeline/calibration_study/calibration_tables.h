// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <string>
#include <vector>

#include "datasets/paper/printed_tables.h"
#include "datasets/results/figure.h"
#include "datasets/results/table.h"
#include "pipeline/calibration_study/calibration_summary.h"

namespace trilat {

// The ways to find the ball that bins and figures show.
inline constexpr std::array kMainWandMethods{"ours", "corrected", "corrected by the mid-range"};

inline const PrintedCalibration& paper_calibration() {
  static const PrintedCalibration printed = printed_calibration();
  return printed;
}

inline std::string source_text(bool simulated) { return simulated ? "simulated" : "recorded"; }

// Tables of a calibration study, beside the paper's statements; a part that was not run gives none.
StoredTables calibration_tables(const CalibrationSummary& summary);

// The paper's two calibration figures: error against distance and angle, and depth error against image
// column. Each needs its recordings.
std::vector<Figure> calibration_figures(const CalibrationSummary& summary);

}  // namespace trilat
