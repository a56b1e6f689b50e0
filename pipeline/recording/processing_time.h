// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/results/timings.h"
#include "pipeline/recording/recording_study.h"
#include "pipeline/study/watch.h"

namespace trilat {

// Cost of a frame from the bodies of all sensors to 25 trilaterated joints, by each of the study's
// methods, one frame at a time on one thread; then the same with the declared body tracking. Frames are those
// of a simulated person walking. Throws Interrupted.
std::vector<StageTiming> time_processing(const RecordingSpec& spec, const Watch& watch);

// Bins and quantiles of what is a number.
TimeSpread spread_times(std::vector<double> times_s);

}  // namespace trilat
