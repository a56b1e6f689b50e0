// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "datasets/session/agent_clock.h"
#include "datasets/session/arrival_envelope.h"

namespace trilat {

// An arrival on the host clock; not certain close to where the agent's clock was set anew.
struct HostArrival {
  HostTime time;
  bool certain = true;
};

// Places arrivals, given in the order of the recording, on the host clock: which setting of the agent's clock
// one belongs to follows from that order where the readings alone leave it open.
class HostArrivals {
 public:
  explicit HostArrivals(const AgentClock& clock) : clock_(&clock) {}
  HostArrival place(SensorTime device, AgentTime arrival);

 private:
  bool can_be(std::size_t segment, AgentTime arrival) const;
  HostArrival chosen(SensorTime device, AgentTime arrival);

  const AgentClock* clock_;
  std::size_t segment_ = 0;
  std::optional<ArrivalStamp> before_;
};

}  // namespace trilat
