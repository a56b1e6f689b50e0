// SPDX-License-Identifier: MIT
#include "datasets/session/clock/true_clocks.h"

#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/strict_json.h"

namespace trilat {

std::optional<TrueClocks> true_clocks(const SessionReader& session, const std::string& sensor) {
  const std::filesystem::path file = session.path().parent_path() / "truth.json";
  if (!session.header().simulated || !std::filesystem::exists(file)) return std::nullopt;
  const Json json = read_json(file);
  JsonObject object(json, file.string(), "");
  const HostTime start{object.integer("motion_start_host_ns")};
  for (JsonObject& entry : object.objects("sensors")) {
    if (entry.text("name") != sensor) continue;
    const ClockMap<AgentTag, HostClock> agent_from_host{
        start,
        {start.ns + entry.integer("agent_minus_host_at_start_ns")},
        entry.number("agent_from_host_drift", 0.0)};
    return TrueClocks{{{entry.integer("sensor_clock_origin_ns")},
                       {entry.integer("host_at_origin_ns")},
                       entry.number("host_from_sensor_drift", 0.0)},
                      agent_from_host.inverse()};
  }
  throw InputError(file.string(), "has no sensor \"" + sensor + '"');
}

}  // namespace trilat
