// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "datasets/base/time.h"
#include "datasets/session/session_types.h"

namespace trilat {

struct AgentTag {};
using AgentTime = Instant<AgentTag>;

// How well an agent's clock is known at an instant.
struct OffsetDoubt {
  std::int64_t sigma_ns = 0;  // standard deviation, of delays alike both ways
  std::int64_t bound_ns = 0;  // the most that unlike delays can do to it
  Duration outside;           // to the first or last exchange
};

// The spread of one fitted stretch of a clock; beyond its exchanges another ppm is added for warming.
struct OffsetSpread {
  AgentTime rest_from, rest_to;  // between these `sigma_ns` holds
  double sigma_ns = 0.0;
  double drift_sigma = 0.0;  // adds with the distance from there
};

// One setting of an agent's clock, from its first exchange to its last: the clock runs on, at a rate of its
// own that may wander.
struct AgentSegment {
  AgentTime first, last;
  ClockMap<HostClock, AgentTag> line;
  PiecewiseClock<HostClock, AgentTag> host_from_agent;
  bool has_drift = false;  // long enough to tell it
  OffsetSpread spread;
  std::int64_t offset_sigma_ns = 0;  // the largest from `first` to `last`
  // Of the exchanges of least delay the worst: half its delay, and how far the clock is from its midpoint.
  std::int64_t offset_bound_ns = 0;

  OffsetDoubt doubt(AgentTime t) const;
};

// How the clock of the machine that stamps arrivals relates to the recording's host clock. Without exchanges
// the two are the same, and there are no segments.
struct AgentClock {
  std::vector<AgentSegment> segments;  // in the order of the recording
  std::size_t exchanges = 0;
  std::size_t exchanges_used = 0;           // of least delay
  std::size_t exchanges_backwards = 0;      // left out
  std::size_t exchanges_contradicting = 0;  // left out

  // By the segment that holds `t`, or lies nearest.
  HostTime operator()(AgentTime t) const;
  // Of that segment; nothing where there is none.
  OffsetDoubt doubt(AgentTime t) const;
};

// From four-stamp exchanges: per segment a straight line through the exchanges of least delay (Theil and
// Sen's median slope; no drift of its own when they span less than 10 s), or, where that leaves more than 0.3
// ms in the medians of two neighbouring 10 s, straight pieces through those medians. A constant difference
// between the delays of both ways moves the clock by half of it, which no exchange can show.
AgentClock fit_agent_clock(std::span<const ClockExchange> exchanges);

}  // namespace trilat
