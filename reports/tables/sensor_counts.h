// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/results/summary.h"
#include "reports/figures/figure.h"
#include "reports/tables/table.h"

namespace trilat {

// Families of methods, one for each set of so many sensors: their mean, best and worst set; and families
// named "METHOD, N sensors" as a figure of error against N. Empty for a study without families of sets.
std::vector<Table> sensor_counts_table(const ResultsSummary& summary);
std::vector<Figure> sensor_counts_figure(const ResultsSummary& summary);

// The summary without the methods that stand for one of several sets: the tables of families speak for them.
// What is by take stays whole.
ResultsSummary without_sets(ResultsSummary summary);

}  // namespace trilat
