// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <vector>

#include "pipeline/sweep/sweep_plan.h"

namespace trilat {

struct SweepRunOptions {
  std::function<bool()> stop_requested = {};
  std::function<void(double)> progress = {};  // share of the trials done
};

struct SweepRun {
  std::vector<SweepCell> cells;  // in the order of the plan's cells
  bool interrupted = false;      // cells then hold the trials that were done, perhaps none
};

// Trials per piece of work; every piece is computed whole or not at all.
inline constexpr std::size_t kChunkTrials = 8192;

// Computes every cell on the threads of the current arena. Equal plans give equal cells whatever the number
// of threads; the memory needed does not grow with the trials.
SweepRun run_sweep(const SweepPlan& plan, const SweepRunOptions& options);

}  // namespace trilat
