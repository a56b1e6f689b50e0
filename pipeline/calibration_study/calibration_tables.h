// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/results/figure.h"
#include "datasets/results/table.h"
#include "pipeline/calibration_study/calibration_summary.h"

namespace trilat {

// Tables of a calibration study, beside the paper's statements; a part that was not run gives none.
StoredTables calibration_tables(const CalibrationSummary& summary);

// The paper's two calibration figures, from simulated samples: error against distance and angle, and depth
// error against image column. Each needs its part of the study.
std::vector<Figure> calibration_figures(const CalibrationSummary& summary);

}  // namespace trilat
