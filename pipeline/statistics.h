// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "datasets/results/samples.h"
#include "datasets/results/summary.h"
#include "pipeline/aligned_errors.h"
#include "pipeline/plan.h"
#include "pipeline/runner.h"
#include "pipeline/take_statistics.h"

namespace trilat {

// Block sums of a study are kept in memory; blocks are made longer until they fit.
inline constexpr std::uint64_t kBlockSumBytes = 64'000'000;
inline constexpr std::uint64_t kMostBlocks = 4096;

StatisticsLayout statistics_layout(const Plan& plan, const SamplesHeader& samples, const Axes& axes);

// Adds to a summary that has its cells: their intervals, the average over the groups, differences from the
// reference, whole bodies, and what is known of the truth. Streams the samples once. Participants are the
// clusters: all takes of one in a condition belong together. Sums are taken in the order of the takes and
// random numbers are a function of their place, whatever the threads.
void add_statistics(const Plan& plan, const RunOutcome& outcome, const SamplesFile& samples, const Axes& axes,
                    const std::vector<TakeAlignments>& alignments, ResultsSummary& summary);

}  // namespace trilat
