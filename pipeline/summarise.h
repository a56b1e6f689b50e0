// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>

#include "datasets/results/samples.h"
#include "datasets/results/summary.h"
#include "pipeline/plan.h"
#include "pipeline/runner.h"

namespace trilat {

inline constexpr std::uint64_t kDistancesInMemoryBytes = 256'000'000;

// Aligns every take's estimates, writes the error column of samples.h5 for the study's first alignment, and
// computes all cells: condition x group x method x alignment. Streams the samples, so memory does not grow
// with the takes: distances, for their quantiles, are kept in memory while they fit in `budget_bytes`, and
// beside the samples, in a file without a name, when they do not. Sums are taken in the order of the takes,
// whatever the threads. `progress` is told the share that is done.
ResultsSummary summarise(const Plan& plan, const RunOutcome& outcome, SamplesFile& samples,
                         std::uint64_t budget_bytes = kDistancesInMemoryBytes,
                         const std::function<void(double)>& progress = {});

}  // namespace trilat
