// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/results/budget_summary.h"
#include "reports/table.h"

namespace trilat {

// One table for each condition and alignment: a row for every method and joint group, a column for every
// source of error alone, their sum and what all of them together give; and a table of what the sources are.
std::vector<Table> budget_tables(const BudgetSummary& summary);

}  // namespace trilat
