// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "evaluators/calibration/two_positions.h"
#include "pipeline/calibration/calibrate_wand.h"

namespace trilat {

// The paper's calibration from the first two wand positions (eq. 6 and 7), as printed or corrected. Without
// `movement_m` the wand moved by the mean of what the sensors saw. Each sensor's vertical is its floor
// plane's where the session has one, unless `upright`: then it is the sensor's own y axis, as the paper
// assumes. InputError when a sensor did not see both positions or has no angle, with the reason.
Calibration calibrate_two_positions(const WandViews& views, const std::filesystem::path& session,
                                    const TwoPositionOptions& options, std::optional<double> movement_m,
                                    bool upright);

}  // namespace trilat
