// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/results/calibration_summary.h"
#include "reports/table.h"

namespace trilat {

// The tables of a calibration study beside the paper's statements; a part that was not run gives none.
std::vector<Table> calibration_tables(const CalibrationSummary& summary);

// Finding the wand: every method in every scene, and two of them by distance and by angle.
Table calibration_wand_table(const CalibrationSummary& summary);
Table calibration_bins_table(const CalibrationSummary& summary);
// A flat wall: the paper's bad columns against those between them, one row a unit.
Table calibration_distortion_table(const CalibrationSummary& summary);
// The poses of whole rigs, one row a method.
Table calibration_rigs_table(const CalibrationSummary& summary);
// How an uncertain calibration carries into joints.
Table calibration_effect_table(const CalibrationSummary& summary);

}  // namespace trilat
