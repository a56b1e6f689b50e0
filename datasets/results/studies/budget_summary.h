// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "datasets/base/strict_json.h"
#include "datasets/results/summary.h"

namespace trilat {

// One method's error in one joint group with one source of error alone ("none" and "all" are sources too).
struct BudgetRow {
  std::string source, method, condition, group, alignment;
  std::uint64_t n = 0;  // answered
  double rmse_m = kNoNumber;
  double mae_m = kNoNumber;
};

// An error budget: a simulated campaign evaluated once for every source of error alone and once with all.
// Squares of independent errors add, so the root of the sum of rmse^2 over the sources is held against `all`.
struct BudgetSummary {
  std::string study, campaign;
  std::uint64_t seed = 0, participants = 0;
  double calibration_sigma_m = 0.0, calibration_sigma_rad = 0.0;
  std::vector<std::string> sources;       // in their order
  std::vector<std::string> descriptions;  // of each
  std::vector<BudgetRow> rows;
};

Json json_of(const BudgetRow& row);
BudgetRow read_budget_row(JsonObject object);

// summary.json (results format 1, kind error_budget). NaN is written as null.
void write_budget_summary(const std::filesystem::path& folder, const BudgetSummary& summary);
BudgetSummary read_budget_summary(const std::filesystem::path& folder);

}  // namespace trilat
