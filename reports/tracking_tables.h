// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/results/tracking_summary.h"
#include "reports/table.h"

namespace trilat {

// What a run says of how its sensors tracked: which views each rule rejects and how often rightly, by joint
// and by sensor; exchanges of left and right; the clocks' offset by motion. Tables without rows are left out.
std::vector<Table> tracking_tables(const TrackingSummary& summary);

}  // namespace trilat
