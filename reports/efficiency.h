// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/results/summary.h"
#include "datasets/results/tracking_summary.h"
#include "reports/table.h"

namespace trilat {

// One table a condition: how near the methods that use ranges come to the Cramer-Rao bound of the ranges they
// get. Only of errors before any alignment; without them, or without ranges, there is none.
std::vector<Table> efficiency_tables(const ResultsSummary& summary, const TrackingSummary& tracking);

}  // namespace trilat
