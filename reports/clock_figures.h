// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/results/recording_summary.h"
#include "reports/figure.h"

namespace trilat {

// Histograms of the clock errors over the paper's ranges, one figure a network: the paper's beside every
// method.
std::vector<Figure> clock_figures(const RecordingSummary& summary);

}  // namespace trilat
