// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/accuracy/take/take_data.h"

namespace trilat {

// What the sensors of a take say against each other: the same stream twice, a mirrored one, poses that were
// exchanged or are far off or change during the take, a clock that is off, ranges or positions of another
// scale. Each note has its size and the remedy; a sound take has none. `bodies`: as they were read, before
// anything is repaired.
std::vector<TakeNote> check_sensors(const Plan& plan, const PlannedTake& planned, const BodyTracks& bodies);

}  // namespace trilat
