// SPDX-License-Identifier: MIT
#pragma once

#include "datasets/results/table.h"
#include "pipeline/clocks/clocks_summary.h"

namespace trilat {

// Table IV beside the paper's: clock errors, what the queue drops, each computer's clock and the way of its
// frames; the paper's processing time stands by itself, since nothing here can test it.
StoredTables clocks_tables(const ClocksSummary& summary);

}  // namespace trilat
