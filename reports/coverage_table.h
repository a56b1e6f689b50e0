// SPDX-License-Identifier: MIT
#pragma once

#include "datasets/results/summary.h"
#include "reports/table.h"

namespace trilat {

// How many samples each method answered in each condition, all joint groups together, and how all ended.
// Statuses do not depend on the alignment. Without rows when the results hold none.
Table coverage_table(const ResultsSummary& summary);

}  // namespace trilat
