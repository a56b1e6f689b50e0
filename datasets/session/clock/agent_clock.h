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
struct OffsetUncertainty {
  std::int64_t sigma_ns = 0;  // standard deviation, of delays alike both ways
  std::int64_t bound_ns = 0;  // the most that unlike delays can do to it
  Duration outside;           // to the first or last exchange
};

// The clock of the machine that stamps arrivals against the recording's host clock, as a straight line.
// Without exchanges both read the same.
struct AgentClock {
  ClockMap<HostClock, AgentTag> line;
  AgentTime first, last;   // of the exchanges
  bool has_drift = false;  // they last long enough to tell it
  std::size_t exchanges = 0;
  std::size_t exchanges_used = 0;       // of least delay
  std::size_t exchanges_backwards = 0;  // left out

  // Standard deviations: of the clock about its line, of the line at its middle, of its drift.
  double residual_sigma_ns = 0.0, middle_sigma_ns = 0.0, drift_sigma = 0.0;
  std::int64_t bound_ns = 0;  // half the delay of the exchanges used and their distance from the line
  // Largest distance of some seconds from the line beyond their noise, and where. What unlike delays may
  // explain counts up to 20 ms, so that a larger one is a clock that was set.
  Duration deviation;
  Duration deviation_after;  // since `first`

  HostTime operator()(AgentTime t) const { return line(t); }
  OffsetUncertainty uncertainty(AgentTime t) const;
  // The largest from the first to the last exchange.
  std::int64_t sigma_ns() const;
};

// From four-stamp exchanges: Theil and Sen's line through the quarter of least delay, those that queueing
// disturbed least; no drift of its own when they span less than 10 s. Its uncertainty is that of medians of
// 10 s each about the line. A constant difference between the delays of both ways moves the clock by half of
// it, which no exchange can show.
AgentClock fit_agent_clock(std::span<const ClockExchange> exchanges);

// The clock of a sensor's computer as a live system knows it: by the exchange of least delay of the last
// eight that were answered by then, as NTP's clock filter (RFC 5905, section 10). Equations 20 and 21 of the
// paper, the signs of their first line corrected (erratum E11). Before the first exchange it is the first;
// without any both clocks are the same.
class LiveClock {
 public:
  explicit LiveClock(std::span<const ClockExchange> exchanges);
  HostTime operator()(AgentTime t) const;

 private:
  struct Known {
    AgentTime answered;
    Duration delay, host_minus_agent;
  };
  std::vector<Known> exchanges_;  // by `answered`
};

}  // namespace trilat
