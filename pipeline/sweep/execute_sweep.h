// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "datasets/results/sweep_summary.h"
#include "datasets/results/sweep_timings.h"
#include "pipeline/sweep/sweep_plan.h"

namespace trilat {

struct ExecuteSweepOptions {
  int threads = 0;  // 0: as many as there are processors
  std::function<bool()> stop_requested = {};
  std::function<void(double)> progress = {};         // of the trials
  std::function<void(double)> timing_progress = {};  // of the timing, which follows
};

struct SweepOutcome {
  SweepSummary summary;
  std::optional<SweepTimings> timings;
  std::filesystem::path folder;  // where the results are: `output`, or when interrupted `output`.partial
};

// Runs a sweep and writes the results folder: manifest.json, summary.json, run.json and, when it is timed,
// timings.json. When interrupted the summary of what was done is in `output`.partial.
SweepOutcome execute_sweep(const SweepPlan& plan, const std::filesystem::path& output,
                           const ExecuteSweepOptions& options);

}  // namespace trilat
