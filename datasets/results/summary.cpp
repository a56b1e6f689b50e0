// SPDX-License-Identifier: MIT
#include "datasets/results/summary.h"

namespace trilat {

void ResultsSummary::check(const JsonObject& object) const {
  if (alignments.empty()) object.refuse("alignments", "must name at least one alignment");
}

void write_summary(const std::filesystem::path& folder, const ResultsSummary& summary) {
  write_results(folder, summary);
}

ResultsSummary read_summary(const std::filesystem::path& folder) {
  return read_results<ResultsSummary>(folder);
}

const SummaryCell* find_cell(const ResultsSummary& summary, const std::string& method,
                             const std::string& condition, const std::string& group,
                             const std::string& alignment) {
  for (const SummaryCell& cell : summary.cells)
    if (cell.method == method && cell.condition == condition && cell.group == group &&
        cell.alignment == alignment)
      return &cell;
  return nullptr;
}

const BestMethod* find_best(const ResultsSummary& summary, const std::string& condition,
                            const std::string& group) {
  for (const BestMethod& best : summary.best)
    if (best.condition == condition && best.group == group) return &best;
  return nullptr;
}

}  // namespace trilat
