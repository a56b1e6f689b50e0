// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "pipeline/accuracy/take/plan.h"

namespace trilat {

// The clock of a recorded sensor, by which its frames get their times. As fit_sensor_clock(); InputError for
// exact clocks of a session without the truth.json of a simulation beside it.
SensorClockMap clock_of(const SessionReader& session, std::size_t sensor, SensorClocks clocks);

// Opens the session, calibration, mapping and truth of a planned take, for the sensors of the rig, and plans
// its instants. InputError with the place where the take cannot be evaluated.
void open_take(PlannedTake& planned, const std::vector<std::string>& rig, const StudySpec& study);

}  // namespace trilat
