// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/results/summary.h"
#include "reports/table.h"

namespace trilat {

// One table a condition and alignment: every group and method with n, coverage, statuses and all statistics;
// behind it the differences from the reference, and behind those of a condition its whole bodies.
std::vector<Table> accuracy_tables(const ResultsSummary& summary);

// The paper's Table III beside ours: walking, errors relative to the mean, every method, with an average row
// as the paper has it (the plain mean of the groups). Our method stands beside the printed column that its
// name starts with. Empty when the results hold nothing of the kind.
std::vector<Table> table3(const ResultsSummary& summary);

// The paper's Table II beside ours: arms and legs, occluded samples and all. Empty for a study without them.
std::vector<Table> table2(const ResultsSummary& summary);

}  // namespace trilat
