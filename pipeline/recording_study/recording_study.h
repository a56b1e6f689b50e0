// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "pipeline/recording_study/recording_spec.h"
#include "pipeline/study/study.h"

namespace trilat {

// Times a recording in real time, in a folder that does not exist yet. Not of this room: it takes recorders.
using TimeCapture = std::function<std::vector<StageTiming>(
    const RecordingSpec& spec, const std::filesystem::path& folder, const Watch& watch)>;

// Simulated clocks and queues of a recording, and what a frame costs on this machine. Its summary.json is a
// RecordingSummary. Without `time_capture` no recording is timed.
Study recording_study(const RecordingSpec& spec, const TimeCapture& time_capture = {});

}  // namespace trilat
