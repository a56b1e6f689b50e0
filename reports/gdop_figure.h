// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/results/gdop_map.h"
#include "datasets/results/summary.h"
#include "reports/figure.h"

namespace trilat {

// The rig from above: how well ranges fix a point at each place, and where the sensors stand.
Figure gdop_figure(const GdopMap& map, const ResultsSummary& summary);

}  // namespace trilat
