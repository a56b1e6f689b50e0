// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

#include "datasets/rig/campaign.h"
#include "datasets/synthetic/simulation_spec.h"
#include "pipeline/study/hash_cache.h"
#include "pipeline/study/study.h"

namespace trilat {

// Makes a simulated campaign on the threads of the current arena: a folder of takes with campaign.json, which
// says that all are there, calibration.json, simulator.json and, when there is a wand, its recording in
// wand/. `sha256`: of the documents that the simulation was read from, which `inputs` watches. Goes on from
// recordings that an interrupted run of the same simulation left; an earlier one in the folder is replaced.
// Throws Interrupted.
ItemCounts record_campaign(const SimulationSpec& spec, const std::string& sha256, const WatchedFiles& inputs,
                           const std::filesystem::path& folder, const StudyOptions& options);

// Simulates a campaign anew, and reads it.
Campaign simulate_campaign(const SimulationSpec& spec, const std::filesystem::path& folder,
                           const RunControl& control);

}  // namespace trilat
