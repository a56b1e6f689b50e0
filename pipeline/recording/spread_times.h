// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/results/time_spread.h"

namespace trilat {

// Bins and quantiles of what is a number.
TimeSpread spread_times(std::vector<double> times_s);

}  // namespace trilat
