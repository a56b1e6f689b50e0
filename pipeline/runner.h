// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <vector>

#include "datasets/results/replay.h"
#include "datasets/results/samples.h"
#include "datasets/results/summary.h"
#include "datasets/results/tracking_summary.h"
#include "pipeline/memory_budget.h"
#include "pipeline/plan.h"

namespace trilat {

struct RunOptions {
  bool cross_check = false;
  std::function<bool()> stop_requested = {};
  std::function<void(double)> progress = {};            // share of the work done
  std::uint64_t memory_bytes = half_of_memory_bytes();  // takes are evaluated at once as far as they fit
};

// Where the time of a run went, in seconds summed over threads.
struct StageTimes {
  double read_s = 0.0;
  double solve_s = 0.0;
  double write_s = 0.0;
  double summarise_s = 0.0;  // wall clock
};

struct RunOutcome {
  std::vector<TakeNote> notes;  // in the order of the takes
  std::vector<bool> evaluated;  // by take
  std::optional<CrossCheck> cross_check;
  TrackingSummary tracking;
  std::vector<ReplayTake> replays;  // of the first take of each condition, when it was evaluated
  StageTimes times;
};

// The layout of samples.h5 for this plan.
SamplesHeader samples_header(const Plan& plan);

// Sends every take of the plan through every method into its slot of `samples`. A take that fails is noted
// and leaves its slots empty; the others go on. Throws Interrupted when asked to stop.
RunOutcome run_plan(const Plan& plan, SamplesFile& samples, const RunOptions& options);

}  // namespace trilat
