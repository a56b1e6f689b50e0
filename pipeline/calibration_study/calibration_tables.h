// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "datasets/paper/printed_tables.h"
#include "datasets/results/figure.h"
#include "datasets/results/table.h"
#include "pipeline/calibration_study/calibration_numbers.h"

namespace trilat {

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
