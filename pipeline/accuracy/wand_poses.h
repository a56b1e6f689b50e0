// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "datasets/rig/campaign.h"
#include "pipeline/accuracy/methods/study_spec.h"
#include "pipeline/study/hash_cache.h"
#include "pipeline/study/run_control.h"

namespace trilat {

bool asks_for_wand(const StudySpec& study);

// The study with the calibrations that its stages ask for, made from the campaign's wand into
// `results`/poses/KEY/METHOD.json; the key is a hash of the wand's files and this build, and one that is
// there is taken as it is. A study whose poses are all stated comes back as it is, and nothing is written.
// InputError where the campaign names no wand, and as calibrate_wand().
StudySpec with_wand_poses(StudySpec study, const Campaign& campaign, const std::filesystem::path& results,
                          HashCache& hashes, const RunControl& control);

}  // namespace trilat
