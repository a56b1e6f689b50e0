// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "datasets/results/figure.h"
#include "datasets/results/table.h"
#include "datasets/results/timings.h"
#include "pipeline/sweep/sweep_summary.h"

namespace trilat {

// Tables of a sweep: the paper's Table I beside ours, and every cell.
StoredTables sweep_tables(const SweepSummary& summary, const SweepTimings& timings);

// Error, steps, share of answers and, with time_problems, time over the threshold C: a panel for each rig,
// error model and range of errors, a line for each other choice. With the paper's grid its Table I stands
// beside.
std::vector<Figure> sweep_figures(const SweepSummary& summary, const SweepTimings& timings);

// Microseconds a solve of a cell of the summary; NaN where they are not known.
double solve_us(const SweepSummary& summary, const SweepTimings& timings, const SweepCell& cell);

}  // namespace trilat
