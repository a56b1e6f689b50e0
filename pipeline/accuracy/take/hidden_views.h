// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <vector>

#include "pipeline/accuracy/take/take_data.h"
#include "pipeline/accuracy/tracking_summary.h"

namespace trilat {

// Whether the take is simulated with all true joints beside its session (truth.csv).
bool knows_hidden_views(const Take& take);

// 1 for every view from which a joint is truly hidden: less than the share of it that the simulated tracker
// needs is visible past the generated person's own body, sensors standing as the take's calibration says.
// InputError where the take's true joints are not known; Interrupted when asked to stop.
OcclusionCounts hidden_views(const PlannedTake& planned, const PreparedTake& data,
                             const std::function<bool()>& stop_requested);

// Counts of the views that each rule marks and that are truly hidden, by joint group; empty where the truly
// hidden views are not known.
std::vector<RuleRow> judge_rules(const Plan& plan, const PlannedTake& planned, const PreparedTake& data);

// The Cramer-Rao bound of the position error, by joint group: a mean over the instants with a truth and three
// ranges that span space. Range errors are taken as independent, and as large as their average.
std::vector<BoundRow> bounds_of(const Plan& plan, const PlannedTake& planned, const PreparedTake& data);

}  // namespace trilat
