// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <optional>

#include "datasets/results/studies/sweep_timings.h"
#include "pipeline/sweep/sweep_plan.h"

namespace trilat {

// Times the first time_problems trials of every cell on one thread: one at a time, and many side by side,
// each with its start. The cells take turns for time_repeats rounds, so that a busy moment of the machine
// hurts them alike. Nothing when interrupted.
std::optional<SweepTimings> time_sweep(const SweepPlan& plan, const std::function<bool()>& stop_requested,
                                       const std::function<void(double)>& progress);

}  // namespace trilat
