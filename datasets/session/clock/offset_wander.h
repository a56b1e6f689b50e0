// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "datasets/base/time.h"
#include "datasets/session/clock/offset_samples.h"
#include "datasets/session/session_types.h"

namespace trilat {

// A clock's offset from a straight line, by the median of the least delayed exchanges of some seconds.
struct WanderWindow {
  std::int64_t host_ns = 0;  // middle of those exchanges
  double residual_ns = 0.0;
  double sigma_ns = 0.0;  // standard deviation of the residual
  std::size_t exchanges = 0;
};

// 10 s each, longer where these hold fewer than twelve exchanges. `exchanges` by t1.
std::vector<std::vector<ClockExchange>> in_windows(const std::vector<ClockExchange>& exchanges);

// Of each of these windows. Exchanges with more than twice
// `usual_delay_ns` are left out, and windows that keep fewer than three.
std::vector<WanderWindow> wander_windows(const std::vector<ClockExchange>& exchanges, std::int64_t base_ns,
                                         const OffsetLine& line, std::int64_t usual_delay_ns);

// Whether no two neighbouring windows leave the line to the same side by more than 0.3 ms or, if that is
// more, four standard deviations: one alone is more likely a disturbance of the network.
bool is_straight(const std::vector<WanderWindow>& windows);

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
