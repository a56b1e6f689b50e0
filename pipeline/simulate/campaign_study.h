// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

#include "datasets/synthetic/simulation_spec.h"
#include "datasets/take/campaign.h"
#include "pipeline/study/hash_cache.h"
#include "pipeline/study/study.h"

namespace trilat {

inline constexpr const char* kCampaign = "campaign";      // Study::kind
inline constexpr const char* kRecordings = "recordings";  // the first part of the ids of its items

// A simulated campaign; an item is a recording. It is a folder of takes with campaign.json, calibration.json
// and, when there is a wand, its recording in wand/; not a results folder. `sha256`: of the documents that
// the simulation was read from, which `inputs` watches.
Study campaign_study(const SimulationSpec& spec, const std::string& sha256, const WatchedFiles& inputs);
// To put parts together. InputError when that is not what they share.
Study campaign_of_parts(const Json& work, const std::string& place);

// Simulates a whole campaign into `folder`, which it replaces, on the threads of the current arena. Throws
// Interrupted.
Campaign simulate_campaign(const SimulationSpec& spec, const std::filesystem::path& folder,
                           const Watch& watch);

}  // namespace trilat
