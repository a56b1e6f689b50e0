// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "datasets/calibration/calibration.h"
#include "pipeline/calibration/wand_views.h"

namespace trilat {

// A calibration that has been written to `output`, on stdout: the sensors, what was left out, and what a
// person should look at before trusting it. `evidence`: one a sensor, or empty.
void print_calibration(const Calibration& calibration, const std::vector<SensorEvidence>& evidence,
                       const std::filesystem::path& output, bool json);

}  // namespace trilat
