// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/results/summary.h"
#include "reports/figure.h"
#include "reports/table.h"

namespace trilat {

// Error against the number of sensors: a row for every number and method of a study whose methods are named
// "METHOD, N sensors", the average over the joint groups; and the same as a figure. Empty for other studies.
std::vector<Table> sensor_counts_table(const ResultsSummary& summary);
std::vector<Figure> sensor_counts_figure(const ResultsSummary& summary);

}  // namespace trilat
