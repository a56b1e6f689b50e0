// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "datasets/results/summary.h"
#include "datasets/results/table.h"

namespace trilat {

// Two results of one study: what changed, the real changes first; and the sentences that lead.
Table changes_table(const ErrorChanges& changes);
std::vector<std::string> changes_sentences(const ErrorChanges& changes);

// Measurements of real sensors, beside simulated numbers: recorded.json, which scripts/measure_tracker
// writes.
Table recorded_table();

}  // namespace trilat
