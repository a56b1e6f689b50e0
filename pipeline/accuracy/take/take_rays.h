// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/accuracy/take/take_data.h"
#include "pipeline/accuracy/tracking_summary.h"

namespace trilat {

// Disagreement of a take's sensors along and across their rays, all joints of the plan together. Looks at
// some instants, spread evenly.
RayNoiseRow estimate_ray_noise(const Plan& plan, const PlannedTake& planned, const PreparedTake& data);

// Whether some method's calibration is "estimated".
bool estimates_calibration(const Plan& plan);

// Estimates by all joints of the body, at instants spread evenly, how the sensors stand beside the
// calibration.
void find_corrections(const PlannedTake& planned, PreparedTake& data);

// For methods whose sigma is "estimated": each half of the take gets the sigmas that the other half shows,
// joint by joint, left and right together. Does nothing when no method asks.
void estimate_sigmas(const Plan& plan, const PlannedTake& planned, PreparedTake& data);

}  // namespace trilat
