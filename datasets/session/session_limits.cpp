// SPDX-License-Identifier: MIT
#include "datasets/session/session_limits.h"

namespace trilat {

std::string refusal_of(const SensorDescription& sensor) {
  if (sensor.tick_ns < 1 || sensor.tick_ns > 1'000'000'000)
    return "has a device tick outside 1 to 1000000000 ns";
  if (!(sensor.nominal_rate_hz > 0.1 && sensor.nominal_rate_hz < 10'000.0))
    return "has a frame rate outside 0.1 to 10000 Hz";
  return implausibility_of(sensor.intrinsics);
}

}  // namespace trilat
