// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "datasets/session/clock/agent_clock.h"
#include "datasets/session/clock/tick_epochs.h"
#include "datasets/session/session_reader.h"

namespace trilat {

// A frame's exposure on the sensor's clock, as its ticks say.
SensorTime device_time(const SensorDescription& sensor, const FrameStamp& stamp);

// One unbroken count of a sensor's ticks, and where it stands on the host clock.
struct SensorEpoch {
  SensorTime first, last;
  std::uint64_t frames = 0;
  double drift = 0.0;
  PiecewiseClock<HostClock, SensorClock> host_from_sensor;
};

// What the frames themselves say of the fit, at their worst.
struct StampEvidence {
  OffsetDoubt doubt;  // each number's own worst
  Duration lateness_median, lateness_p99;
  double drift_left_out = 0.0;
};

// From a frame's stamps to its exposure on the host clock of the session, the stated latency taken off.
struct SensorClockMap {
  std::int64_t tick_ns = 100;
  Duration latency;
  AgentClock agent;
  std::vector<SensorEpoch> epochs;  // in the order of the recording
  StampEvidence stamps;

  // Of several epochs that which the stamps fit best.
  HostTime operator()(const FrameStamp& stamp) const;
  // By the epoch that holds `t`, or lies nearest: enough where the sensor was never restarted.
  HostTime operator()(SensorTime t) const;
};

// Calls `take` for every frame in the order of the recording.
using EachStamp = std::function<void(const std::function<void(const FrameStamp&)>& take)>;

// By the lower envelope of ticks against arrivals: its segment under the middle, or, where some 10 s leave
// that by more than 0.3 ms, straight pieces along the least late frames. Anew for every restart. `place`
// names the sensor in errors: InputError without frames, or when a drift is beyond 1000 ppm, which means that
// ticks, arrivals or exchanges are not what they are said to be.
SensorClockMap fit_sensor_clock(const SensorDescription& sensor, const EachStamp& each_stamp,
                                std::span<const ClockExchange> exchanges, const std::string& place);

// Of a recorded sensor, by its body frames, or its depth frames where there are no bodies.
SensorClockMap fit_sensor_clock(const SessionReader& session, std::size_t sensor);

// What a reader wants to know of a fit.
struct ClockEvidence {
  std::size_t sensor_epochs = 0, sensor_pieces = 0;
  std::size_t agent_segments = 0, agent_pieces = 0;
  double sensor_drift_ppm = 0.0;  // host against sensor, of the epoch with most frames
  double agent_drift_ppm = 0.0;   // host against agent, of the longest segment
  std::size_t exchanges = 0, exchanges_used = 0, exchanges_backwards = 0, exchanges_contradicting = 0;
  std::int64_t offset_sigma_ns = 0;  // between agent and host, of the frame where it is worst
  std::int64_t offset_bound_ns = 0;  // what unlike delays can add, at most
  double outside_exchanges_s = 0.0;  // of the frame that is farthest from any exchange
  double lateness_median_s = 0.0, lateness_p99_s = 0.0;  // of arrivals, above the least late ones
  double drift_left_out_ppm = 0.0;  // of a sensor, beyond 1000 ppm in less than 5 s; taken as none
};
ClockEvidence evidence_of(const SensorClockMap& map);

}  // namespace trilat
