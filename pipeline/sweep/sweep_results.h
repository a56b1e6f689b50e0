// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "datasets/results/sweep_summary.h"
#include "datasets/results/sweep_timings.h"
#include "pipeline/sweep/sweep_runner.h"

namespace trilat {

// What the cells of a plan add up to; when they are not complete, nothing is searched in them.
SweepSummary summary_of(const SweepPlan& plan, std::vector<SweepCell> cells, bool complete);

// Whether the folder holds the finished results of just this plan and build.
bool holds_sweep(const std::filesystem::path& folder, const SweepPlan& plan);

// manifest.json, summary.json, and of a sweep that was not interrupted items.json and, when it was timed,
// timings.json: equal plans give equal bytes, times apart.
void write_sweep_results(const std::filesystem::path& folder, const SweepPlan& plan,
                         const SweepSummary& summary, const std::optional<SweepTimings>& timings);

// For run.json: which items were taken from where.
Json reused_json(const SweepPlan& plan, const SweepTally& tally);

}  // namespace trilat
