// SPDX-License-Identifier: MIT
#include "datasets/results/studies/tracking_summary.h"

#include "datasets/results/results_file.h"

namespace trilat {

void write_tracking_summary(const std::filesystem::path& folder, const TrackingSummary& summary) {
  write_beside(folder / "tracking.json", "trilat.tracking", summary);
}

std::optional<TrackingSummary> read_tracking_summary(const std::filesystem::path& folder) {
  return read_beside<TrackingSummary>(folder / "tracking.json", "trilat.tracking");
}

}  // namespace trilat
