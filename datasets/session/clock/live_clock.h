// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "datasets/session/clock/agent_clock.h"

namespace trilat {

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
