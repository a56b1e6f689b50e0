// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "datasets/rig/campaign.h"
#include "pipeline/study/recordings.h"
#include "pipeline/study/study.h"

namespace trilat {

// A study of kind "calibration": how exactly sensors see a ball and a flat wall, by a campaign's wand,
// stated distances and walls.
struct CalibrationSpec : RecordingsStudy {
  std::uint64_t frames = 5;  // of a place, whose mean is a sample

  static void fields(auto& self, Fields& f) {
    visit_head(self, f, StudyKind::calibration);
    for (const char* key : {"units", "samples", "distortion_units", "runs", "rig", "seed"})
      f.removed(key, "name a campaign whose recordings it takes; \"bench\" in a simulation makes some");
    f("frames", self.frames,
      opt("Largest number of frames of a place, whose mean is a sample", {1.0, 1000.0}));
  }
};

// How many recordings the campaign has that sensors can be calibrated by. InputError where it has none.
std::size_t calibration_recordings(const CalibrationSpec& spec, const Campaign& campaign);

// Evaluates them, each an item, on the threads of the current arena; one that cannot be evaluated fails and
// is named. summary.json is a CalibrationSummary. InputError where the campaign has no such recording, or
// none can be evaluated; throws Interrupted.
ItemCounts run_calibration(const CalibrationSpec& spec, const Campaign& campaign,
                           const std::filesystem::path& folder, const StudyOptions& options);

}  // namespace trilat
