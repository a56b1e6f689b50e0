// SPDX-License-Identifier: MIT
#include "datasets/session/clock/true_clocks.h"

#include <nlohmann/json.hpp>

#include "datasets/base/document.h"
#include "datasets/base/error.h"

namespace trilat {
namespace {

// The part of a simulated take's truth.json that concerns clocks.
struct SensorTruth {
  static constexpr bool kHasMore = true;
  std::string name;
  std::int64_t agent_minus_host_at_start_ns = 0, sensor_clock_origin_ns = 0, host_at_origin_ns = 0;
  double agent_from_host_drift = 0.0, host_from_sensor_drift = 0.0;

  static void fields(auto& self, auto&& f) {
    f("name", self.name, "agent_minus_host_at_start_ns", self.agent_minus_host_at_start_ns,
      "sensor_clock_origin_ns", self.sensor_clock_origin_ns, "host_at_origin_ns", self.host_at_origin_ns);
    f("agent_from_host_drift", self.agent_from_host_drift, kMayLack);
    f("host_from_sensor_drift", self.host_from_sensor_drift, kMayLack);
  }
};
struct TakeTruth {
  static constexpr bool kHasMore = true;
  std::int64_t motion_start_host_ns = 0;
  std::vector<SensorTruth> sensors;

  static void fields(auto& self, auto&& f) {
    f("motion_start_host_ns", self.motion_start_host_ns, "sensors", self.sensors);
  }
};

}  // namespace

std::optional<TrueClocks> true_clocks(const SessionReader& session, const std::string& sensor) {
  const std::filesystem::path file = session.path().parent_path() / "truth.json";
  if (!session.header().simulated || !std::filesystem::exists(file)) return std::nullopt;
  const auto truth = read_as<TakeTruth>(read_json(file), file);
  const HostTime start{truth.motion_start_host_ns};
  for (const SensorTruth& s : truth.sensors) {
    if (s.name != sensor) continue;
    const ClockMap<AgentTag, HostClock> agent_from_host{
        start, {start.ns + s.agent_minus_host_at_start_ns}, s.agent_from_host_drift};
    return TrueClocks{{{s.sensor_clock_origin_ns}, {s.host_at_origin_ns}, s.host_from_sensor_drift},
                      agent_from_host.inverse()};
  }
  throw InputError(file.string(), "has no sensor \"" + sensor + '"');
}

}  // namespace trilat
