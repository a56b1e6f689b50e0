// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "datasets/session/session_reader.h"

namespace trilat {

// The clocks that a simulation gave one sensor and its computer.
struct TrueClocks {
  ClockMap<HostClock, SensorClock> host_from_sensor;
  ClockMap<HostClock, AgentTag> host_from_agent;
};

// True clocks that truth.json beside a simulated session states; nothing where there is none. InputError for
// a sensor that it does not name.
std::optional<TrueClocks> true_clocks(const SessionReader& session, const std::string& sensor);

}  // namespace trilat
