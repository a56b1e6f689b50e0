// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "datasets/results/table.h"
#include "datasets/results/timings.h"
#include "pipeline/recording/recording_summary.h"

namespace trilat {

// Table IV beside the paper's: clock errors, what the queue drops, what the corrected fit says of itself,
// and, where it was timed, what a frame costs and which share of the frames is processed in time.
StoredTables recording_tables(const RecordingSummary& summary, const std::optional<StageTimings>& timings);

}  // namespace trilat
