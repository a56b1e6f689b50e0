// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/take_clocks.h"

#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/session/clock/live_clock.h"

namespace trilat {
namespace {

// Line from the sensor's clock to the host's, as truth.json beside the session states it.
ClockMap<HostClock, SensorClock> true_line(const std::filesystem::path& truth, const std::string& sensor) {
  const Json json = read_json(truth);
  JsonObject object(json, truth.string(), "");
  for (JsonObject& entry : object.objects("sensors"))
    if (entry.text("name") == sensor)
      return {{entry.integer("sensor_clock_origin_ns")},
              {entry.integer("host_at_origin_ns")},
              entry.number("host_from_sensor_drift", 0.0)};
  throw InputError(truth.string(), "has no sensor \"" + sensor + '"');
}

}  // namespace

SensorClockMap clock_of(const SessionReader& session, std::size_t sensor, SensorClocks clocks) {
  SensorClockMap map = fit_sensor_clock(session, sensor);
  if (clocks == SensorClocks::exact) {
    const std::filesystem::path truth = session.path().parent_path() / "truth.json";
    if (!std::filesystem::exists(truth))
      throw InputError(session.path().string(),
                       "has no truth.json beside it, so its exact clocks are not known: \"sensor_clocks\": "
                       "\"exact\" is for simulations");
    map.epochs.resize(1);
    map.epochs[0].line = true_line(truth, session.header().sensors[sensor].name);
    map.epochs[0].line.origin_to = map.epochs[0].line.origin_to + map.latency;
  }
  if (clocks == SensorClocks::causal) map.live = LiveClock(session.clock_exchanges(sensor));
  if (clocks == SensorClocks::printed) map.live = [](AgentTime arrival) { return HostTime{arrival.ns}; };
  return map;
}

}  // namespace trilat
