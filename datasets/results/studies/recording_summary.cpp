// SPDX-License-Identifier: MIT
#include "datasets/results/studies/recording_summary.h"

#include <algorithm>

#include "datasets/results/results_file.h"

namespace trilat {

void RecordingSummary::check(const JsonObject& object) const {
  const auto whole = [&](const ClockErrorRow& row) { return row.units.size() == runs * sensors; };
  if (!std::all_of(clocks.begin(), clocks.end(), whole))
    object.refuse("clocks", "must have units of each run and sensor");
}

void write_recording_summary(const std::filesystem::path& folder, const RecordingSummary& summary) {
  write_results(folder, StudyKind::recording, summary, -1);
}

RecordingSummary read_recording_summary(const std::filesystem::path& folder) {
  return read_results<RecordingSummary>(folder, StudyKind::recording);
}

}  // namespace trilat
