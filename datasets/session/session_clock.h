// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "datasets/base/time.h"
#include "datasets/session/session_reader.h"

namespace trilat {

// One frame's stamps on the sensor's clock (ticks turned to ns) and on the clock of the machine it
// arrived at.
struct ArrivalStamp {
  SensorTime device;
  std::int64_t arrival_ns = 0;
};

// How the clock of the machine that stamps arrivals relates to the recording's host clock, from
// four-stamp exchanges: offset(t) = agent - host, by a straight line through the exchanges of least
// delay (Theil and Sen's median slope; none when they span less than 10 s). Those that run backwards are left
// out. Without exchanges the two clocks are the same.
// `worst_residual_ns` is that of the exchanges used.
struct AgentClock {
  struct AgentTag {};
  ClockMap<HostClock, AgentTag> host_from_agent;
  std::int64_t worst_residual_ns = 0;
  std::size_t exchanges_used = 0;
};
AgentClock fit_agent_clock(std::span<const ClockExchange> exchanges);

// A sensor's clock against arrival times: the lower envelope of (device, arrival), since a frame
// can be late but not early; its segment under the middle of the recording gives offset and drift.
// Gathers points one by one and keeps only the hull.
class ArrivalEnvelope {
 public:
  void add(const ArrivalStamp& stamp);
  // One stamp gives drift 0; none is an error of the caller.
  ClockMap<AgentClock::AgentTag, SensorClock> line() const;
  bool empty() const { return hull_.empty(); }

 private:
  std::vector<ArrivalStamp> hull_;
};

// The map from one sensor's clock to the host clock of the session, stated latency taken off. Uses
// body frames, or depth frames where there are no bodies. InputError when the sensor has no frames
// or the drift found is beyond 1000 ppm, which means that ticks or arrivals are not what the
// session says.
ClockMap<HostClock, SensorClock> fit_sensor_clock(const SessionReader& session, std::size_t sensor);

// A frame's exposure on the sensor's clock.
SensorTime device_time(const SensorDescription& sensor, const FrameStamp& stamp);

}  // namespace trilat
