// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/results/calibration_summary.h"
#include "reports/table.h"

namespace trilat {

// The tables of a calibration study beside the paper's numbers.
std::vector<Table> calibration_tables(const CalibrationSummary& summary);

}  // namespace trilat
