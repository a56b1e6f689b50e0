// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "datasets/results/sweep_summary.h"
#include "datasets/results/sweep_timings.h"
#include "reports/figure.h"

namespace trilat {

// Table I as curves over the threshold C, the paper's beside ours with the printed and the corrected
// gradient: error and steps of every reading that has a table, and the time of a solve where it was measured.
std::vector<Figure> sweep_figures(const SweepSummary& summary, const std::optional<SweepTimings>& timings);

}  // namespace trilat
