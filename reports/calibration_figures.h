// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/results/calibration_summary.h"
#include "reports/figure.h"

namespace trilat {

// What the paper draws of its calibration, from simulated samples: error by distance and by angle, a flat
// wall by column; and how uncertain sensors carry into joints. A part that was not run gives none.
std::vector<Figure> calibration_figures(const CalibrationSummary& summary);

}  // namespace trilat
