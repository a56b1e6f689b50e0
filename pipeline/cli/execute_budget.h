// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "datasets/results/budget_summary.h"
#include "pipeline/budget_spec.h"
#include "pipeline/memory_budget.h"

namespace trilat {

struct BudgetOptions {
  int threads = 0;  // 0: as many as there are processors
  std::function<bool()> stop_requested = {};
  std::function<void(const std::string&, double)> progress = {};  // the source, and the share of it done
  std::uint64_t memory_bytes = half_of_memory_bytes();
};

// Simulates the campaign once for every source of error and evaluates it into a results folder of kind
// error_budget; the campaigns themselves are not kept. Throws Interrupted when asked to stop.
BudgetSummary execute_budget(const BudgetSpec& spec, const std::filesystem::path& output,
                             const BudgetOptions& options);

}  // namespace trilat
