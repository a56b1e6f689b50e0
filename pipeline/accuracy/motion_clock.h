// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string>

#include "pipeline/accuracy/take_data.h"

namespace trilat {

struct MotionClock {
  ClockRow row;
  std::string warning;  // what the trackers' lag does not explain, for the take's notes; empty when it does
};

// By how much the mocap's stated start is off, as the motion shows: the mean of the sensors' positions
// against the ground truth. `data` has its times and bodies.
MotionClock clock_by_motion(const Plan& plan, const PlannedTake& planned, const TakeData& data,
                            const std::function<bool()>& stop_requested);

}  // namespace trilat
