// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

#include "evaluators/solvers/point_estimate.h"
#include "pipeline/stream_fit/point_stream.h"

namespace trilat {

// Lag of a view behind others, and its standard deviation.
struct ViewLag {
  double lag_s = kNaN, sigma_s = kNaN;
};

// The lag, up to a second, at which the movements of both about each instant (0.1 s to both sides) agree
// best, with its standard deviation by a jackknife over blocks of time. What is constant or slow in two
// trackers is not in it. NaN for less than six seconds, and where a block decides or movements agree nearly
// as well without a lag. Both at the same instants.
ViewLag lag_of(const PointStream& view, const PointStream& others);

// A view of one pose until a time and another one from then on.
struct ViewPush {
  double at_s = 0.0, moved_m = 0.0;
  double judged_m = HUGE_VAL, plain_m = HUGE_VAL;  // what two poses leave, as ChangeErrors
};

// The time of all blocks' ends at which two poses leave least.
ViewPush best_push(const PointStream& view, const PointStream& others);

}  // namespace trilat
