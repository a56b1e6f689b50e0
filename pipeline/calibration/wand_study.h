// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/session/session_reader.h"
#include "pipeline/calibration/calibrate_wand.h"
#include "pipeline/study/study.h"

namespace trilat {

inline constexpr const char* kWandSearch = "wand_search";  // Study::kind

// The search for a wand in depth frames, to be divided; an item is a run of neighbouring frames of one
// sensor. It has no results of its own: calibrate_parts() makes a calibration of its parts.
Study wand_study(const std::vector<std::filesystem::path>& files, WandMethod method,
                 const CalibrateWandOptions& options, std::uint64_t frames_of_item = kFramesOfItem);

// What calibrate_wand() would have made of the same sessions. Needs the parts only.
WandCalibration calibrate_parts(const std::vector<FoundPart>& parts);

// Tells recordings apart without reading all of them: a hash of how long the file is, of what the sensors
// are, of every time stamp and clock exchange, and of one depth frame in 1200.
std::string fingerprint_of(const SessionReader& session);

}  // namespace trilat
