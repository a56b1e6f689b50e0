// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
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

// A sensor's clock against arrival times: the lower envelope of (device, arrival), since a frame can be late
// but not early; its segment under the middle gives offset and drift.
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

// Frames between two restarts of a sensor's count of ticks.
struct TickEpoch {
  SensorTime first, last;
  std::uint64_t frames = 0;
  std::vector<ArrivalEnvelope> windows;  // of 10 s each, by time
  ArrivalEnvelope doubtful;              // frames whose arrival is not known for certain
};

// Takes a sensor's frames in the order of the recording and parts them where ticks and arrivals no longer go
// together, by more than 0.1 s. Frames that came late together for less than 2 s make no epoch.
class TickEpochs {
 public:
  explicit TickEpochs(std::int64_t tick_ns) : tick_ns_(tick_ns) {}
  void add(std::int64_t device_ticks, HostTime arrival, bool certain = true);
  std::vector<TickEpoch> finish() const;

 private:
  std::int64_t tick_ns_;
  std::vector<TickEpoch> runs_;
  ArrivalStamp before_;
};

// The lower envelope's segment under the middle of an epoch. One shorter than 5 s has no drift when it would
// be beyond 1000 ppm: in so short a time jitter of the arrivals looks like drift.
ClockMap<HostClock, SensorClock> envelope_line(const TickEpoch& epoch);

// The drift that `envelope_line` does not take from so short an epoch, or 0.
double drift_left_out(const TickEpoch& epoch);

// The same with the drift given when the epoch is shorter than 10 s: through its least late frame.
ClockMap<HostClock, SensorClock> envelope_line(const TickEpoch& epoch, double drift_of_short);

// The line, or straight pieces along the least late frames of 10 s each where one of these leaves the line by
// more than 0.3 ms. Frames that lie above what a clock's drift can change by from the windows beside them are
// late, not wander.
PiecewiseClock<HostClock, SensorClock> envelope_pieces(const TickEpoch& epoch,
                                                       const ClockMap<HostClock, SensorClock>& line);

}  // namespace trilat
