// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "datasets/results/samples.h"
#include "datasets/results/summary.h"
#include "pipeline/accuracy/statistics/take_statistics.h"
#include "pipeline/accuracy/take/plan.h"
#include "pipeline/accuracy/take/take_result.h"

namespace trilat {

// Called once for every take of the plan, from any thread: puts its samples into the file.
using BringTake = std::function<void(std::size_t take)>;

// Aligns every take's estimates, writes the error column of samples.h5 for the study's first alignment, and
// computes all cells: condition x group x method x alignment. Streams the samples: memory holds of each
// answered one its distances alone, 8 bytes an alignment and set, for their quantiles. Sums are taken in the
// order of the takes, whatever the threads. `known`: by take of the plan, what was found when it was
// evaluated; the others are summarised from their samples. `progress` is told the share that is done.
ResultsSummary summarise(const Plan& plan, const RunOutcome& outcome, SamplesFile& samples,
                         std::vector<std::optional<TakeSummary>> known, const BringTake& bring,
                         const std::function<void(double)>& progress);

}  // namespace trilat
