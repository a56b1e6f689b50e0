// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "datasets/take/campaign.h"
#include "pipeline/study/recordings.h"
#include "pipeline/study/study.h"

namespace trilat {

// A study of kind "calibration": how exactly sensors see a ball and a flat wall, by a campaign's wand,
// stated distances and walls.
struct CalibrationSpec : RecordingsStudy {
  std::uint64_t frames = 5;  // of a place, whose mean is a sample
};

CalibrationSpec parse_calibration_spec(const Json& json, const std::string& place,
                                       const std::filesystem::path& folder);

// Every setting written out, defaults included.
Json resolved_json(const CalibrationSpec& spec);

// How many recordings the campaign has that sensors can be calibrated by. InputError where it has none.
std::size_t calibration_recordings(const CalibrationSpec& spec, const Campaign& campaign);

// Evaluates them, each an item, on the threads of the current arena; one that cannot be evaluated fails and
// is named. summary.json is a CalibrationSummary. InputError where the campaign has no such recording, or
// none can be evaluated; throws Interrupted.
ItemTally run_calibration(const CalibrationSpec& spec, const Campaign& campaign,
                          const std::filesystem::path& folder, const StudyOptions& options);

}  // namespace trilat
