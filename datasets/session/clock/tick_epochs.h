// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "datasets/base/time.h"
#include "datasets/session/clock/host_arrivals.h"

namespace trilat {

// After so many ticks a 32-bit counter, as that of libfreenect2, starts again from nothing.
inline constexpr std::int64_t kTicksOfWrap = std::int64_t{1} << 32;

// Frames between two restarts of a sensor's count of ticks.
struct TickEpoch {
  SensorTime first, last;  // wraps of the counter undone
  int wraps = 0;
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
  std::int64_t ticks_before_ = 0;
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
// more than 0.3 ms. Frames that lie above what a clock's drift can change by from the windows beside them
// are late, not wander.
PiecewiseClock<HostClock, SensorClock> envelope_pieces(const TickEpoch& epoch,
                                                       const ClockMap<HostClock, SensorClock>& line);

}  // namespace trilat
