// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/results/item_store.h"
#include "datasets/results/results_file.h"
#include "datasets/results/simulation_assumptions.h"
#include "datasets/results/table.h"

namespace trilat {

// Inputs of a results folder, from its manifest.json, and where it was computed, from run.json. Texts are
// empty where those files do not say.
struct Provenance {
  std::string folder;  // the name of the results folder
  StudyKind kind = StudyKind::accuracy;
  std::string study;  // its name
  std::string program, campaign, seed, study_sha256;
  std::string calibration;  // the file that was given instead of the takes' own
  std::string config;       // the resolved study as JSON
  std::vector<std::string> rig;
  std::vector<Manifest::Input> inputs;
  std::string processor, threads, compiler, wall_s;
  bool is_compared = false;  // by `trilat compare`, without a study and a campaign
};

// Reads both files. InputError when one is of another version, and when the manifest is not of the run that
// summary.json is of: another kind, or a study or campaign of another name. What is not there stays empty.
Provenance read_provenance(const std::filesystem::path& results, StudyKind kind, const std::string& study,
                           const std::string& campaign);

// The folder without dots and slashes that say nothing.
std::filesystem::path whole_path(const std::filesystem::path& folder);
// The name of a folder, also when it is written with a slash behind.
std::string folder_name(const std::filesystem::path& folder);

// The commands that make these results and this report again. The study is the file that the report writes
// beside the page.
std::string commands_of(const Provenance& provenance);
std::string study_file(const Provenance& provenance);  // "studies/table3.json"

// Assumptions of the simulation of one or several studies, with sources.
Table parameters_table(const std::vector<SimulationAssumption>& parameters, const std::string& studies);

}  // namespace trilat
