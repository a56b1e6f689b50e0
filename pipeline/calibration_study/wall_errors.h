// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "datasets/take/campaign.h"
#include "pipeline/calibration_study/calibration_summary.h"
#include "pipeline/study/watch.h"

namespace trilat {

// What each sensor sees of a flat wall, against a plane that is fitted to the mean of its frames. InputError
// where less than four fifths of what a sensor sees lies within 3 cm of one plane.
WallRecording measure_wall(const FlatWall& wall, const std::string& name, const Watch& watch);

}  // namespace trilat
