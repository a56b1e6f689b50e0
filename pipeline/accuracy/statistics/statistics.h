// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "datasets/results/summary.h"
#include "pipeline/accuracy/statistics/take_statistics.h"
#include "pipeline/accuracy/take/plan.h"
#include "pipeline/accuracy/take/take_result.h"

namespace trilat {

// Adds to a summary that has its cells: their intervals, the average over the groups, differences from the
// reference, whole bodies, and what is known of the truth. Participants are the clusters: all takes of one in
// a condition belong together. Sums are taken in the order of the takes and random numbers are a function of
// their place, whatever the threads. `takes`: of the plan.
void add_statistics(const Plan& plan, const RunOutcome& outcome, const StatisticsLayout& layout,
                    std::span<const TakeSummary> takes, ResultsSummary& summary);

}  // namespace trilat
