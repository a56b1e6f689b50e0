// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/take_clocks.h"

#include "datasets/base/error.h"
#include "datasets/session/clock/live_clock.h"
#include "datasets/session/clock/true_clocks.h"

namespace trilat {

SensorClockMap clock_of(const SessionReader& session, std::size_t sensor, SensorClocks clocks) {
  SensorClockMap map = fit_sensor_clock(session, sensor);
  if (clocks == SensorClocks::exact) {
    const std::optional<TrueClocks> truth = true_clocks(session, session.header().sensors[sensor].name);
    if (!truth)
      throw InputError(session.path().string(),
                       "has no truth.json beside it, so its exact clocks are not known: \"sensor_clocks\": "
                       "\"exact\" is for simulations");
    map.epochs.resize(1);
    map.epochs[0].line = truth->host_from_sensor;
    map.epochs[0].line.origin_to = map.epochs[0].line.origin_to + map.latency;
  }
  if (clocks == SensorClocks::causal) map.live = LiveClock(session.clock_exchanges(sensor));
  if (clocks == SensorClocks::printed) map.live = [](AgentTime arrival) { return HostTime{arrival.ns}; };
  return map;
}

}  // namespace trilat
