// SPDX-License-Identifier: MIT
#pragma once

#include "datasets/base/piecewise_clock.h"
#include "datasets/session/tick_epochs.h"

namespace trilat {

// The lower envelope's segment under the middle of an epoch. One shorter than 5 s has no drift when it would
// be beyond 1000 ppm: in so short a time jitter of the arrivals looks like drift.
ClockMap<HostClock, SensorClock> envelope_line(const TickEpoch& epoch);

// The drift that `envelope_line` does not take from so short an epoch, or 0.
double drift_left_out(const TickEpoch& epoch);

// The same with the drift given when the epoch is shorter than 10 s: through its least late frame.
ClockMap<HostClock, SensorClock> envelope_line(const TickEpoch& epoch, double drift_of_short);

// The line, or straight pieces along the least late frames of 10 s each where one of these leaves the line by
// more than 0.3 ms. Frames that lie above what a clock's drift can change by from the windows beside them
// are late, not wander.
PiecewiseClock<HostClock, SensorClock> envelope_pieces(const TickEpoch& epoch,
                                                       const ClockMap<HostClock, SensorClock>& line);

}  // namespace trilat
