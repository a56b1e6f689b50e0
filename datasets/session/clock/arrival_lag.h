// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>

#include "datasets/base/time.h"
#include "datasets/session/session_types.h"

namespace trilat {

struct ArrivalLag {
  double behind_s = 0.0;  // 0: arrivals keep up with the ticks
};

// Whether frames arrive ever later than the sensor's ticks say they were made: by the least lateness of every
// second of ticks. A clock that is set anew does that once, late frames come to an end; more than 0.25 s that
// grow in three seconds or more, by over 1000 ppm each, are a computer that cannot keep up.
class ArrivalLagFinder {
 public:
  explicit ArrivalLagFinder(std::int64_t tick_ns) : tick_ns_(tick_ns) {}
  // In the order of the recording. Ticks that fall back begin anew.
  void add(const FrameStamp& stamp);
  ArrivalLag finish();

 private:
  void end_second();

  std::int64_t tick_ns_;
  SensorTime second_, before_;             // where the second begins; the last frame
  std::optional<std::int64_t> late_ns_;    // the least of this second
  std::optional<std::int64_t> level_ns_;   // of the second before
  std::optional<std::int64_t> lowest_ns_;  // from where the lag is counted
  int growing_ = 0;                        // seconds since then
  std::int64_t behind_ns_ = 0;
};

}  // namespace trilat
