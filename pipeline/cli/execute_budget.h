// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "datasets/results/budget_summary.h"
#include "pipeline/budget_spec.h"
#include "pipeline/items/study_items.h"
#include "pipeline/memory_budget.h"

namespace trilat {

struct BudgetOptions {
  int threads = 0;  // 0: as many as there are processors
  std::function<bool()> stop_requested = {};
  std::function<void(const std::string&, double)> progress = {};  // the source, and the share of it done
  WorkOptions work = {};
  bool fresh = false;          // what `output`.partial holds is not gone on with
  ItemTally* tally = nullptr;  // told what was computed and what was not
  std::uint64_t memory_bytes = half_of_memory_bytes();
};

// Simulates the campaign once for every source of error and evaluates it into a results folder of kind
// error_budget; the campaigns themselves are not kept. An item a source of error. Throws Interrupted when
// asked to stop; the sources that are done stay, and the same budget goes on from there. A shard leaves a
// part folder and an empty summary. Nothing is written when `output` is among the earlier results and holds
// just these.
BudgetSummary execute_budget(const BudgetSpec& spec, const std::filesystem::path& output,
                             const BudgetOptions& options);

// The results that one run would have given, to the byte, but for run.json.
BudgetSummary merge_budget(const std::vector<FoundPart>& parts, const std::filesystem::path& output,
                           const BudgetOptions& options);

}  // namespace trilat
