// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "datasets/session/clock/agent_clock.h"
#include "datasets/session/session_reader.h"

namespace trilat {

// A frame's exposure on the sensor's clock, as its ticks say.
SensorTime device_time(const SensorDescription& sensor, const FrameStamp& stamp);

// One unbroken count of a sensor's ticks, and where it stands on the host clock.
struct SensorEpoch {
  SensorTime first, last;
  std::uint64_t frames = 0;
  ClockMap<HostClock, SensorClock> line;
};

// Evidence of the frames on the fit, at their worst.
struct StampEvidence {
  OffsetUncertainty uncertainty;  // each number's own worst
  Duration lateness_median, lateness_p99;
  Duration deviation;        // by which all frames of some ten seconds are late, at most
  Duration deviation_after;  // where, since the first frame
  double drift_left_out = 0.0;
};

// From a frame's stamps to its exposure on the host clock of the session, the stated latency taken off.
struct SensorClockMap {
  std::int64_t tick_ns = 100;
  Duration latency;
  AgentClock agent;
  std::vector<SensorEpoch> epochs;  // in the order of the recording
  StampEvidence stamps;
  // Host time of an arrival as a live system knows it; where it is set, frames get their times by their
  // arrivals.
  std::function<HostTime(AgentTime)> live = {};

  // By the epoch that the stamps fit best.
  HostTime operator()(const FrameStamp& stamp) const;
  // By the epoch that holds `t`, or lies nearest: enough where the sensor was never restarted.
  HostTime operator()(SensorTime t) const;
};

// "arrivals jump by 5.00 s ..., while its ticks go on: ...", where the clock that stamps arrivals was set
// during the recording; the sensor itself was not restarted.
std::optional<std::string> arrival_jump_text(const SensorClockMap& clock);

// Calls `take` for every frame in the order of the recording.
using EachStamp = std::function<void(const std::function<void(const FrameStamp&)>& take)>;

// A straight line under the arrivals against the ticks, since a frame can be late but not early: the segment
// of their lower envelope under the middle. Anew where ticks and arrivals no longer go together, which is a
// restart of the sensor; an epoch shorter than 10 s has the longest one's drift. `place` names the sensor in
// errors: InputError without frames, where a drift is beyond 1000 ppm, and where exchanges leave a straight
// line by more than 20 ms.
SensorClockMap fit_sensor_clock(const SensorDescription& sensor, const EachStamp& each_stamp,
                                std::span<const ClockExchange> exchanges, const std::string& place);

// Clock of a recorded sensor, by its body frames, or its depth frames where there are no bodies. InputError
// also where ticks or arrivals are in another unit than stated.
SensorClockMap fit_sensor_clock(const SessionReader& session, std::size_t sensor);

}  // namespace trilat
