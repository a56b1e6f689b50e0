// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "datasets/rig/calibration.h"
#include "evaluators/calibration/wand_positions.h"
#include "pipeline/calibration/calibrate_views.h"
#include "pipeline/calibration/wand_in_world.h"
#include "pipeline/calibration/wand_views.h"

namespace trilat {

// All positions, refined together; the paper's eq. 6 and 7, corrected; and as printed.
enum class WandMethod { wand, two_positions, printed };

// Sensor poses from recordings of a wand that was held still at many places. All recordings are of one rig.
// Another method than `wand` gives no positions in the world. Poses from two positions, which are in the
// wand's frame, are brought into OptiTrack's world where `options` has one by a rigid fit of all places, each
// the mean of where the sensors then see it.
WandCalibration calibrate_wand(const std::vector<std::filesystem::path>& files,
                               const CalibrateWandOptions& options, WandMethod method = WandMethod::wand);

// Calibrates by several methods, of one search for the wand.
std::vector<WandCalibration> calibrate_wand_by(std::span<const WandMethod> methods,
                                               const std::vector<std::filesystem::path>& files,
                                               const CalibrateWandOptions& options);

// Calibrates by one method, where the wand was searched for already. `first`: the first recording.
WandCalibration calibrate_searched(WandMethod method, const SessionReader& first,
                                   const CalibrateWandOptions& options, const WandObservations& views);

// The paper's calibration from the first two wand positions (eq. 6 and 7), as printed or corrected. Without
// `baseline_m` the wand moved by the mean of what the sensors saw. `floors`: one entry a sensor, whose normal
// is the sensor's vertical where it has one; else that is the sensor's own y axis, as the paper assumes.
// InputError at `place` when a sensor did not see both positions or has no angle, with the reason.
Calibration calibrate_two_positions(const WandObservations& views, const std::string& place,
                                    const TwoPositionOptions& options, std::optional<double> baseline_m,
                                    std::span<const std::optional<FloorPlane>> floors);

}  // namespace trilat
