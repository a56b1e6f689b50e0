// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>
#include <string>

#include "pipeline/calibration_study/calibration_summary.h"
#include "pipeline/claims/claim_number.h"
#include "pipeline/clocks/clocks_summary.h"
#include "pipeline/sweep/sweep_summary.h"

namespace trilat {

// Among the interpretations of Table I whose every error is within a factor of 2 of the printed one, the
// share in which a smaller threshold costs twice the steps and gains a tenth of accuracy. They are listed,
// not drawn.
Measurement acceptable_interpretations(const SweepSummary& sweep);

// A share over recordings and sensors, from the numbers of each of them that have this key.
Measurement share_of_units(const ClocksSummary& clocks, const NumberKey& key);

// Where a ball is seen: from the first distance (angle from the central line) to below the second.
struct WandZone {
  std::array<double, 2> distance_m{}, angle_deg{};
};

// The mean error of the ball's distance within a zone, corrected by the mid-range of the depths, in the first
// recording of stated distances; less a printed number.
Measurement wand_error(const CalibrationRecordings& calibration, const WandZone& zone, double less_m);
// The same in one zone against another: (zone - other) / other.
Measurement wand_error(const CalibrationRecordings& calibration, const WandZone& zone, const WandZone& other);

}  // namespace trilat
