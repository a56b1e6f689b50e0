// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "datasets/results/summary.h"
#include "pipeline/accuracy/statistics/take_statistics.h"
#include "pipeline/accuracy/take/plan.h"
#include "pipeline/accuracy/take/take_result.h"

namespace trilat {

// Adds to a summary that has its cells: their intervals, the average over the groups, differences from the
// reference, whole bodies, and what is known of the truth. Intervals are Student's t between participants; of
// fewer than three between takes, and of a single take between its blocks of five seconds. Sums are taken in
// the order of the takes, whatever the threads. `takes`: of the plan.
void add_statistics(const Plan& plan, const RunOutcome& outcome, const StatisticsLayout& layout,
                    std::span<const TakeSummary> takes, ResultsSummary& summary);

}  // namespace trilat
