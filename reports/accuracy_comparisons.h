// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "datasets/results/summary.h"
#include "reports/table.h"

namespace trilat {

// Every method against the study's reference, by joint group. Without rows when there is nothing to compare.
Table differences_table(const ResultsSummary& summary, const std::string& condition,
                        const std::string& alignment);

// Whole bodies by method. Without rows when no method has any.
Table bodies_table(const ResultsSummary& summary, const std::string& condition);

// Takes, participants and joints apart, each method's joints together, and each joint of each take: where an
// odd take, person or side shows. Under the study's first alignment.
std::vector<Table> apart_tables(const ResultsSummary& summary);

}  // namespace trilat
