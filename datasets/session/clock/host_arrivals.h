// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "datasets/base/time.h"
#include "datasets/session/clock/agent_clock.h"

namespace trilat {

// One frame's stamps: on the sensor's clock (ticks turned to ns), and its arrival.
struct ArrivalStamp {
  SensorTime device;
  HostTime arrival;

  Duration lateness() const { return {arrival.ns - device.ns}; }
};

// A sensor's clock against arrival times: the lower envelope of (device, arrival), since a frame
// can be late but not early; its segment under the middle gives offset and drift.
// Gathers points one by one and keeps only the hull.
class ArrivalEnvelope {
 public:
  // Stamps that do not rise on the sensor's clock are left out.
  void add(const ArrivalStamp& stamp);
  // One stamp gives drift 0; none is an error of the caller.
  ClockMap<HostClock, SensorClock> line() const;
  bool empty() const { return hull_.empty(); }
  const std::vector<ArrivalStamp>& hull() const { return hull_; }

 private:
  std::vector<ArrivalStamp> hull_;
};

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
