// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <span>

#include "datasets/results/work_part.h"
#include "pipeline/sweep/execute_sweep.h"

namespace trilat {

struct MergeSweepOptions {
  std::function<bool()> stop_requested = {};
  std::function<void(double)> progress = {};
};

// Adds up the parts of a sweep, all there are, as read_parts() gives them. The results are those of a single
// run, to the byte, times apart; the timings are those that the first shard took. The memory needed grows
// neither with the trials nor with the parts. InputError when a part does not hold just its share of every
// cell; Interrupted when asked to stop.
SweepOutcome merge_sweep(std::span<const FoundPart> parts, const std::filesystem::path& output,
                         const MergeSweepOptions& options);

}  // namespace trilat
