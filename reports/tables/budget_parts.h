// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "datasets/results/studies/budget_summary.h"

namespace trilat {

// The root mean square error with one source alone, of the row that is `like` this one but for the source;
// NaN when there is none.
double rmse_of_source_m(const BudgetSummary& summary, const BudgetRow& like, const std::string& source);

// What the source adds to the mean square error: "none" is in every other source and is taken off.
double added_m2(const BudgetSummary& summary, const BudgetRow& like, const std::string& source);

// The root of the sum over all sources, "none" counted once. NaN when one is not known.
double sum_of_sources_m(const BudgetSummary& summary, const BudgetRow& like);

}  // namespace trilat
