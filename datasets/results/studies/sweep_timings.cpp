// SPDX-License-Identifier: MIT
#include "datasets/results/studies/sweep_timings.h"

#include "datasets/results/results_file.h"

namespace trilat {

void write_sweep_timings(const std::filesystem::path& folder, const SweepTimings& timings) {
  write_beside(folder / "timings.json", "trilat.timings", timings);
}

std::optional<SweepTimings> read_sweep_timings(const std::filesystem::path& folder) {
  return read_beside<SweepTimings>(folder / "timings.json", "trilat.timings");
}

}  // namespace trilat
