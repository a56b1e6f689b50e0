// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "pipeline/accuracy/methods/over_time.h"
#include "pipeline/accuracy/take/take_data.h"

namespace trilat {

// How many methods of the plan solve windows of all joints together, which takes long.
std::size_t windowed_methods(const Plan& plan);

// All methods of the plan that need whole paths. Throws Interrupted when asked to stop.
std::vector<MethodPaths> solve_over_time(const Plan& plan, const PlannedTake& planned, const TakeData& data,
                                         const OverTimeCalls& calls);

}  // namespace trilat
