// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "pipeline/items/item_store.h"
#include "pipeline/sweep/sweep_results.h"

namespace trilat {

struct ExecuteSweepOptions {
  int threads = 0;  // 0: as many as there are processors
  std::function<bool()> stop_requested = {};
  std::function<void(double)> progress = {};         // of the trials
  std::function<void(double)> timing_progress = {};  // of the timing, which follows
  WorkOptions work = {};
  bool fresh = false;  // nothing is taken from what `output` or an interrupted run holds
  double save_every_s = 20.0;
};

struct SweepOutcome {
  SweepSummary summary;  // of a shard: of its trials
  std::optional<SweepTimings> timings;
  std::filesystem::path folder;  // where the results are: `output`, or when interrupted `output`.partial
  SweepTally tally;
  bool is_part = false;
  bool unchanged = false;  // `output` held just these results and was left alone
};

// Runs a sweep and writes the results folder: manifest.json, summary.json, items.json, run.json and, when it
// is timed, timings.json. When interrupted the summary of what was done is in `output`.partial, and the next
// run goes on from there. Of a shard it writes a part for merge_sweep().
SweepOutcome execute_sweep(const SweepPlan& plan, const std::filesystem::path& output,
                           const ExecuteSweepOptions& options);

}  // namespace trilat
