// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/calibration_study/calibration_spec.h"
#include "pipeline/study/study.h"

namespace trilat {

// Simulated calibration: one wand position, a flat wall, whole rigs, and what poses that are off do to
// joints. Its summary.json is a CalibrationSummary.
Study calibration_study(const CalibrationSpec& spec);

}  // namespace trilat
