// SPDX-License-Identifier: MIT
#include "pipeline/cli/clock_json.h"

#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/session/session_clock.h"

namespace trilat {

Json clock_json(const SessionReader& session, std::size_t sensor) {
  try {
    const ClockEvidence e = evidence_of(fit_sensor_clock(session, sensor));
    return {{"sensor_restarts", e.sensor_epochs - 1},
            {"sensor_pieces", e.sensor_pieces},
            {"sensor_drift_ppm", e.sensor_drift_ppm},
            {"agent_settings", e.agent_segments},
            {"agent_pieces", e.agent_pieces},
            {"agent_drift_ppm", e.agent_drift_ppm},
            {"offset_sigma_s", 1e-9 * static_cast<double>(e.offset_sigma_ns)},
            {"offset_bound_s", 1e-9 * static_cast<double>(e.offset_bound_ns)},
            {"outside_exchanges_s", e.outside_exchanges_s},
            {"lateness_median_s", e.lateness_median_s},
            {"lateness_p99_s", e.lateness_p99_s},
            {"exchanges_used", e.exchanges_used},
            {"exchanges_backwards", e.exchanges_backwards},
            {"exchanges_contradicting", e.exchanges_contradicting}};
  } catch (const InputError& error) {
    return {{"problem", std::string(error.what())}};
  }
}

}  // namespace trilat
