// SPDX-License-Identifier: MIT
#pragma once

#include "datasets/paper/printed_tables.h"
#include "pipeline/sweep/sweep_summary.h"

namespace trilat {

// A reading is ranked when at least this share of the trials of every cell was answered.
inline constexpr double kMinSearchCoverage = 0.9;
inline constexpr std::size_t kBestListed = 20;

// Ranks the readings of a sweep over the printed thresholds and ranges by the root mean square of log(ours /
// printed) over all cells. Errors: once for the mean distance and once for the mean over the axes. Times:
// mean iterations times one free scale, the best there is, because processors differ; a time printed as "<"
// counts as right unless ours is above it.
SweepSearch search_interpretations(const SweepSummary& summary, const PrintedTable1& printed);

}  // namespace trilat
