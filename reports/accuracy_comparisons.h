// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "datasets/results/summary.h"
#include "reports/table.h"

namespace trilat {

// Every method against the study's reference, by joint group. Without rows when there is nothing to compare.
Table differences_table(const ResultsSummary& summary, const std::string& condition,
                        const std::string& alignment);

// Whole bodies by method. Without rows when no method has any.
Table bodies_table(const ResultsSummary& summary, const std::string& condition);

}  // namespace trilat
