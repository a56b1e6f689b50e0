// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "evaluators/solvers/point_estimate.h"

namespace trilat {

// A share of variance with its 95 % interval; NaN where there is none.
struct VarianceShare {
  double value = kNaN, low = kNaN, high = kNaN;
};

// What share of the variance of `values` a factor explains by itself: the variance of the means of some bins
// of equally many points, in the order of their positions in the factor's range (Plischke, Reliability
// Engineering and System Safety 95, 2010), less what chance alone gives them. Any independent points will do.
// The interval is Student's t of a jackknife over the points. Values that are not finite are left out; NaN
// for fewer than 8.
VarianceShare first_order_index(std::span<const double> positions, std::span<const double> values);

}  // namespace trilat
