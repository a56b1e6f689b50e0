// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/results/budget_summary.h"
#include "reports/figure.h"

namespace trilat {

// What share of the mean square error each source makes, by joint: bars that end at the sum, with what is
// observed beside it. One figure a condition and method, in the first alignment.
std::vector<Figure> budget_figures(const BudgetSummary& summary);

}  // namespace trilat
