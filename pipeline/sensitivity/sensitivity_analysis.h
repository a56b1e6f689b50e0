// SPDX-License-Identifier: MIT
#pragma once

#include "datasets/results/studies/sensitivity_summary.h"

namespace trilat {

// Fills in what the points of a summary say of its claims and methods. Shares, means and break-even values
// are over all points of the space, which is uniform in every factor, with a bootstrap of the design's rows;
// indices are of the difference in percent.
void analyse(SensitivitySummary& summary);

}  // namespace trilat
