// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "pipeline/items/shard.h"
#include "pipeline/sweep/sweep_log.h"
#include "pipeline/sweep/sweep_plan.h"
#include "pipeline/sweep/sweep_stripe.h"

namespace trilat {

struct SweepRunOptions {
  Shard shard{1, 1};  // whose chunks; a cell's trials are then those of the shard
  std::function<bool()> stop_requested = {};
  std::function<void(double)> progress = {};  // share of the trials done
  // The cell as earlier results have it, or null: it must be computed. Asked once for each cell.
  std::function<const SweepRecord::Reused*(std::size_t cell)> earlier = {};
  SweepLog* log = nullptr;     // where it goes on from, and saves to; null: nowhere
  double save_every_s = 20.0;  // at most so much work is lost; the first saves come sooner
};

// Which cells came from where, by their numbers.
struct SweepTally {
  std::vector<std::size_t> computed;
  std::vector<std::size_t> continued;                      // finished or begun by the run that was stopped
  std::map<std::string, std::vector<std::size_t>> reused;  // by the folder

  std::size_t reused_count() const;
  std::size_t all() const { return computed.size() + continued.size() + reused_count(); }
};

struct SweepRun {
  std::vector<SweepCell> cells;  // in the order of the plan's cells
  bool interrupted = false;      // cells then hold the trials that were done, perhaps none
  SweepTally tally;
};

// Trials per piece of work; every piece is computed whole or not at all.
inline constexpr std::size_t kChunkTrials = 8192;

SweepStripe stripe_of(const SweepPlan& plan, const Shard& shard);
std::uint64_t chunks_per_cell(const SweepPlan& plan);
// How many chunks of the cell are the shard's.
std::uint64_t chunks_in_cell(const SweepPlan& plan, const SweepStripe& stripe, std::size_t cell);

// Computes the shard's share of every cell on the threads of the current arena. Equal plans give equal cells
// whatever the number of threads and interruptions; the memory needed does not grow with the trials.
SweepRun run_sweep(const SweepPlan& plan, const SweepRunOptions& options);

}  // namespace trilat
