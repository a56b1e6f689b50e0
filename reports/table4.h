// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "datasets/results/recording_summary.h"
#include "datasets/results/stage_timings.h"
#include "reports/table.h"

namespace trilat {

// Table IV beside the paper's: clock errors, what the queue drops, what the corrected fit says of itself,
// and, where it was timed, what a frame costs.
std::vector<Table> table4(const RecordingSummary& summary, const std::optional<StageTimings>& timings);

Table table4_clocks(const RecordingSummary& summary);
// `timings`: the share of the frames that are processed in time comes from them.
Table table4_queue(const RecordingSummary& summary, const std::optional<StageTimings>& timings);
Table table4_fits(const RecordingSummary& summary);
Table table4_processing(const StageTimings& timings);

}  // namespace trilat
