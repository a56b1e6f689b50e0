// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "datasets/results/stored_take.h"
#include "pipeline/accuracy/methods/method.h"
#include "pipeline/accuracy/take/plan.h"
#include "pipeline/accuracy/take/take_data.h"
#include "pipeline/accuracy/take/take_result.h"
#include "pipeline/study/run_control.h"

namespace trilat {

// Methods that the cross-check compares with Ceres: all nonlinear and newton ones with damping lm, the step
// rule and squares, with the stated calibration.
std::vector<const Method*> checked_methods(const Plan& plan);

// Sends every instant of a take through every method, on the threads of the current arena, and gives away
// block by block in the order of time. `external`: paths of the methods that are not solved here. The result
// is how Ceres compares, by checked method, where that is asked for. Throws Interrupted when asked to stop.
std::vector<TakeCheck> solve_take(const Plan& plan, const PlannedTake& planned, const PreparedTake& data,
                                  std::span<const MethodTrajectories> external, bool cross_check,
                                  const RunControl& control,
                                  const std::function<void(const SampleBlock&)>& each);

}  // namespace trilat
