// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "datasets/results/studies/stage_timings.h"
#include "pipeline/recording/recording_spec.h"
#include "pipeline/study/watch.h"

namespace trilat {

// How long a depth frame takes from its arrival at the sensor's machine until it is written into the session:
// agents of virtual sensors, one a sensor, compress and send in real time over TLS on loopback, and the
// recorder receives and stores, all on this machine. `folder` is for keys and session, which are removed.
// Throws Interrupted.
std::vector<StageTiming> time_capture(const RecordingSpec& spec, const std::filesystem::path& folder,
                                      const Watch& watch);

}  // namespace trilat
