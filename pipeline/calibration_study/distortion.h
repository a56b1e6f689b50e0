// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/results/studies/calibration_summary.h"
#include "pipeline/calibration_study/calibration_spec.h"
#include "pipeline/calibration_study/study_units.h"
#include "pipeline/study/study.h"

namespace trilat {

// The paper's distortion figure: a flat wall square to the lens, per column of the middle row. Frames are
// rendered and added up one by one; none is kept. An item a unit.
std::vector<Item> distortion_items(const CalibrationSpec& spec);
std::vector<DistortionCurve> read_distortion(const CalibrationSpec& spec, const Outcomes& outcomes);

}  // namespace trilat
