// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "datasets/results/samples.h"
#include "datasets/results/summary.h"
#include "datasets/results/tracking_summary.h"
#include "pipeline/items/hash_cache.h"
#include "pipeline/items/item_store.h"
#include "pipeline/memory_budget.h"
#include "pipeline/plan.h"
#include "pipeline/take_key.h"
#include "pipeline/take_result.h"

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

// Where a run puts what it has computed, and asks for what it need not compute.
struct RunPlace {
  std::filesystem::path folder;  // the unfinished output; a take's samples go to takes/ID
  ItemStore& items;
  HashCache& hashes;
  std::vector<WatchedFiles> inputs;  // by take, from before the plan was made
};

struct TakesRun {
  std::vector<EvaluatedTake> takes;  // of the plan; empty results where they are another shard's
  StageTimes times;
};

// The layout of samples.h5 for these takes of the plan; all of them without a list.
SamplesHeader samples_header(const Plan& plan);
SamplesHeader samples_header(const Plan& plan, std::span<const std::size_t> takes);

// InputError when the study has no method that could be checked against Ceres.
void check_cross_check(const Plan& plan);

// Sends takes through every method, each into a folder of its own; those that are done already are found, not
// computed. A take that fails is noted; the others go on. Throws Interrupted when asked to stop; what is done
// stays.
TakesRun run_takes(const Plan& plan, std::span<const std::size_t> takes, const RunPlace& place,
                   const RunOptions& options);

// What the takes of a plan say together.
struct RunOutcome {
  std::vector<TakeNote> notes;  // in the order of the takes
  std::vector<bool> evaluated;  // by take
  std::optional<CrossCheck> cross_check;
  TrackingSummary tracking;
};
RunOutcome outcome_of(const Plan& plan, std::span<const EvaluatedTake> takes, bool cross_check);

}  // namespace trilat
