// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "datasets/results/work_part.h"
#include "pipeline/items/shard.h"
#include "pipeline/sweep/sweep_plan.h"

namespace trilat {

inline constexpr const char* kSweepPart = "threshold_sweep";  // WorkPart::kind

// A part of a sweep: its shard's sums of every cell are in sums.jsonl beside it, and the first one also has
// the timings.
WorkPart part_of(const SweepPlan& plan, const Shard& shard);
// The plan that all its parts share.
SweepPlan plan_of(const WorkPart& part, const std::string& place);

}  // namespace trilat
