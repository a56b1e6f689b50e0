// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/recording/recording_spec.h"
#include "pipeline/study/study.h"

namespace trilat {

// Simulated clocks and queues of a recording, and what a frame costs on this machine. Its summary.json is a
// RecordingSummary.
Study recording_study(const RecordingSpec& spec);

}  // namespace trilat
