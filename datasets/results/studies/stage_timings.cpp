// SPDX-License-Identifier: MIT
#include "datasets/results/studies/stage_timings.h"

#include "datasets/results/results_file.h"

namespace trilat {

void write_stage_timings(const std::filesystem::path& folder, const StageTimings& timings) {
  write_beside(folder / "timings.json", "trilat.stage_timings", timings);
}

std::optional<StageTimings> read_stage_timings(const std::filesystem::path& folder) {
  return read_beside<StageTimings>(folder / "timings.json", "trilat.stage_timings");
}

}  // namespace trilat
