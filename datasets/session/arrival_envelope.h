// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/base/time.h"

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

}  // namespace trilat
