// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>

#include "datasets/results/gate_history.h"
#include "pipeline/gate/found_results.h"
#include "pipeline/gate/gate_report.h"
#include "pipeline/gate/judge_cells.h"

namespace trilat {

struct CompareOptions {
  GateLimits limits;
  std::size_t resamples = 2000;
  std::function<bool()> stop_requested = {};
};

// Everything of a gate but speed and history: finds both nights' results, refuses what cannot be compared
// (InputError), compares each study exactly first and in numbers where it differs, and judges all together.
GateReport compare_results(const std::filesystem::path& results, const std::filesystem::path& baseline,
                           const CompareOptions& options);

// Adds what a history keeps of results to `entry`: error and coverage of every cell of accuracy studies, of
// the first alignment.
void add_series(const ResultsSet& results, HistoryEntry& entry);

}  // namespace trilat
