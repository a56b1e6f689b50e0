// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>

#include "datasets/calibration/calibration.h"
#include "evaluators/calibration/two_positions.h"
#include "pipeline/calibration/floor_plane.h"
#include "pipeline/calibration/wand_views.h"

namespace trilat {

// The paper's calibration from the first two wand positions (eq. 6 and 7), as printed or corrected. Without
// `movement_m` the wand moved by the mean of what the sensors saw. `floors`: one entry a sensor, whose normal
// is the sensor's vertical where it has one; else that is the sensor's own y axis, as the paper assumes.
// InputError at `place` when a sensor did not see both positions or has no angle, with the reason.
Calibration calibrate_two_positions(const WandViews& views, const std::string& place,
                                    const TwoPositionOptions& options, std::optional<double> movement_m,
                                    std::span<const std::optional<FloorPlane>> floors);

}  // namespace trilat
