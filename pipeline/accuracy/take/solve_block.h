// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/results/stored_take.h"
#include "pipeline/accuracy/methods/over_time.h"
#include "pipeline/accuracy/take/plan.h"
#include "pipeline/accuracy/take/take_data.h"
#include "pipeline/accuracy/take/take_result.h"

namespace trilat {

// The methods that are compared with Ceres: all nonlinear and newton ones with damping lm, the step rule and
// squares, with the stated calibration.
std::vector<const Method*> checked_methods(const Plan& plan);

// Sends every instant of a block, which has its size already, through every method on the threads of the
// current arena; `paths` is what the methods over time have found. The result is how Ceres compares, by
// checked method, where that is asked for.
std::vector<TakeCheck> solve_block(const Plan& plan, const PlannedTake& planned, const TakeData& data,
                                   const std::vector<MethodPaths>& paths, bool cross_check,
                                   SampleBlock& block);

// Puts the part of a path that a block is of into it.
void store_path(const Plan& plan, const MethodPaths& paths, SampleBlock& block);

// How many methods of the plan solve windows of all joints together, which takes long.
std::size_t windowed_methods(const Plan& plan);

// All methods of the plan that need whole paths. Throws Interrupted when asked to stop.
std::vector<MethodPaths> solve_over_time(const Plan& plan, const PlannedTake& planned, const TakeData& data,
                                         const OverTimeCalls& calls);

}  // namespace trilat
