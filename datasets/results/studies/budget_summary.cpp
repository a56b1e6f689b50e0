// SPDX-License-Identifier: MIT
#include "datasets/results/studies/budget_summary.h"

#include "datasets/results/results_file.h"

namespace trilat {

void BudgetSummary::check(const JsonObject& object) const {
  if (descriptions.size() != sources.size()) object.refuse("descriptions", "must be as many as the sources");
}

void write_budget_summary(const std::filesystem::path& folder, const BudgetSummary& summary) {
  write_results(folder, StudyKind::error_budget, summary);
}

BudgetSummary read_budget_summary(const std::filesystem::path& folder) {
  return read_results<BudgetSummary>(folder, StudyKind::error_budget);
}

}  // namespace trilat
