// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "evaluators/calibration/wand_positions.h"
#include "evaluators/ceres/rig_refinement.h"
#include "pipeline/calibration/calibrate_wand.h"

namespace trilat {

// Where OptiTrack saw the wand while it rested: the mean over each position's interval. Positions that the
// export does not cover, or at which the asset moved by more than 5 mm, are left out. InputError when fewer
// than three are left.
std::vector<KnownPoint> known_positions(const WandInWorld& world, std::span<const WandPosition> positions);

}  // namespace trilat
