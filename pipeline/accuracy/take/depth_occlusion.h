// SPDX-License-Identifier: MIT
#pragma once

#include <functional>

#include "datasets/session/session_reader.h"
#include "pipeline/accuracy/take/take_data.h"

namespace trilat {

// 1 for every instant, sensor and joint that the depth frame nearest in time shows to be hidden; an instant
// without a depth frame within half a frame hides nothing. InputError when a sensor recorded no depth.
OcclusionCounts find_hidden(const Plan& plan, const PlannedTake& planned, const SessionReader& session,
                            const std::function<bool()>& stop_requested, const TakeData& data);

}  // namespace trilat
