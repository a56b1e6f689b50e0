// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "datasets/base/piecewise_clock.h"
#include "datasets/session/session_types.h"

namespace trilat {

struct AgentTag {};
using AgentTime = Instant<AgentTag>;

// What exchanges of some seconds leave open, whatever the delays were: t2 was not before t1, nor t3 after t4.
struct CorridorWindow {
  AgentTime first, last;
  std::int64_t bound_ns = 0;  // of a fitted clock's error
};

// Windows of 10 s, longer where these hold fewer than twelve exchanges. A window whose exchanges agree with
// the clock takes a neighbour's bound, with 50 ppm of the time between them added, where that is less.
std::vector<CorridorWindow> corridor_windows(const std::vector<ClockExchange>& exchanges,
                                             const PiecewiseClock<HostClock, AgentTag>& host_from_agent);

// How well an agent's clock is known at an instant.
struct OffsetDoubt {
  std::int64_t sigma_ns = 0;  // standard deviation, of delays alike both ways
  std::int64_t bound_ns = 0;  // the most that unlike delays can do to it
  Duration outside;           // to the nearest exchanges
};

// The spread of one fitted stretch of a clock; beyond its exchanges another ppm is added for warming.
struct OffsetSpread {
  AgentTime rest_from, rest_to;  // between these `sigma_ns` holds
  double sigma_ns = 0.0;
  double drift_sigma = 0.0;  // adds with the distance from there
  std::vector<CorridorWindow> windows;
};
OffsetDoubt doubt_at(const OffsetSpread& spread, AgentTime t);

}  // namespace trilat
