// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "pipeline/calibration/wand_work.h"

namespace trilat {

// Sensor poses from recordings of a wand that was held still at many places. All recordings are of one rig.
// Of another method than `wand` there are no positions in the world.
WandCalibration calibrate_wand(const std::vector<std::filesystem::path>& files,
                               const CalibrateWandOptions& options, WandMethod method = WandMethod::wand);

// The same of depth frames that have been searched already: of every recording one entry a sensor.
WandCalibration calibrate_searched(const WandWork& work,
                                   const std::vector<std::vector<SensorSearch>>& searches);

}  // namespace trilat
