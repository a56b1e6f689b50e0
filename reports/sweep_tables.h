// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "datasets/results/sweep_summary.h"
#include "datasets/results/sweep_timings.h"
#include "reports/table.h"

namespace trilat {

// The paper's Table I beside ours, one table for each reading that was run with the printed and with the
// corrected gradient: propagation error, iterations and time of a solve. Empty when the sweep's thresholds or
// error ranges are not the paper's.
std::vector<Table> table1(const SweepSummary& summary, const std::optional<SweepTimings>& timings);

// The answer of an interpretation search: the readings that fit the printed errors best, those that fit the
// printed times, and what the smallest threshold costs with either gradient. Empty without a search.
std::vector<Table> search_tables(const SweepSummary& summary);

// Every number of every cell, one table a reading; for many readings, of those only that lead a ranking.
std::vector<Table> sweep_tables(const SweepSummary& summary, const std::optional<SweepTimings>& timings);

// Of a cell; none when it was not timed.
const SweepCellTiming* timing_of(const std::optional<SweepTimings>& timings, const SweepCell& cell);

// A sentence or two a person can take away from the search; empty without one.
std::vector<std::string> search_sentences(const SweepSummary& summary);

}  // namespace trilat
