// SPDX-License-Identifier: MIT
#include "datasets/results/studies/twins_summary.h"

#include "datasets/results/results_file.h"

namespace trilat {

void write_twins_summary(const std::filesystem::path& folder, const TwinsSummary& summary) {
  write_results(folder, StudyKind::twins, summary);
}

TwinsSummary read_twins_summary(const std::filesystem::path& folder) {
  return read_results<TwinsSummary>(folder, StudyKind::twins);
}

}  // namespace trilat
