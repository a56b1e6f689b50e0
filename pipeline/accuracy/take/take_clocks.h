// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

#include "datasets/session/clock/session_clock.h"
#include "pipeline/accuracy/methods/study_spec.h"

namespace trilat {

// The clock of a recorded sensor, by which its frames get their times. As fit_sensor_clock(); InputError for
// exact clocks of a session without the truth.json of a simulation beside it.
SensorClockMap clock_of(const SessionReader& session, std::size_t sensor, SensorClocks clocks);

}  // namespace trilat
