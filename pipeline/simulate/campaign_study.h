// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

#include "datasets/synthetic/simulation_spec.h"
#include "datasets/take/campaign.h"
#include "pipeline/study/hash_cache.h"
#include "pipeline/study/study.h"

namespace trilat {

// A simulated campaign; an item is a recording. `sha256`: of the documents that the simulation was read from,
// which `inputs` watches.
Study campaign_study(const SimulationSpec& spec, const std::string& sha256, const WatchedFiles& inputs);

// Makes it: a folder of takes with campaign.json, which says that all are there, calibration.json,
// simulator.json and, when there is a wand, its recording in wand/. Goes on from recordings that an
// interrupted run of the same study left; an earlier simulation in the folder is replaced. Throws
// Interrupted.
ItemTally record_campaign(const Study& study, const std::filesystem::path& folder,
                          const StudyOptions& options);

// Simulates a whole campaign into `folder` on the threads of the current arena. Throws Interrupted.
Campaign simulate_campaign(const SimulationSpec& spec, const std::filesystem::path& folder,
                           const Watch& watch);

}  // namespace trilat
