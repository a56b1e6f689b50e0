// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "datasets/base/json.h"
#include "datasets/results/gate_history.h"
#include "datasets/results/results_file.h"

namespace trilat {

// One results folder that a gate may read: finished, of this version, not empty.
struct FoundResults {
  std::string name;  // its folder's, inside a folder that holds several; else the study's
  std::filesystem::path folder;
  StudyKind kind = StudyKind::accuracy;
  std::string study;
  Json manifest, summary;
  std::string numbers = {};  // text of numbers.csv, where the kind has it
};

struct ResultsSet {
  bool single = false;  // the folder itself is the results
  std::vector<FoundResults> results;
};

// A results folder, or all that are directly inside a folder, in the order of their names. InputError, with
// the place, for results that are not finished (NAME.partial), of another version, empty or damaged, and when
// there are none.
ResultsSet find_results(const std::filesystem::path& folder);

struct ResultsPair {
  FoundResults now, before;
};
struct MatchedStudies {
  std::vector<ResultsPair> pairs;
  std::vector<std::string> only_now, only_before;
};

// The studies that both nights have: by folder name, or by the study's own where one side is a single one.
MatchedStudies match_studies(ResultsSet now, ResultsSet before);

// A single value as it is, of a list or object as much as a message has room for.
std::string shortened(const Json& value);

// The settings that differ, each with both values: those of the study, the campaign, and the calibration and
// mapping of each take. Defaults of the code are not settings, nor is what a simulated clock wrote.
std::vector<std::string> settings_that_differ(const ResultsPair& pair);

// The ids of the takes of a study, by whether session and motion capture have the same content.
struct MatchedTakes {
  std::vector<std::string> same, other, one_sided;
};
MatchedTakes match_takes(const ResultsPair& pair);

// The studies of the baseline that would not be in it any more.
std::vector<std::string> studies_only_in_baseline(const std::filesystem::path& results,
                                                  const std::filesystem::path& baseline);

// Makes the results of `results` the baseline, with their items and with accepted.json beside them. The copy
// is made aside and exchanged in one step, so that there is always one whole baseline. A single results
// folder replaces just its study where the baseline holds several. InputError when the reason is empty, the
// results are not what find_results() takes, or `baseline` is a folder of something else.
AcceptedBaseline accept_results(const std::filesystem::path& results, const std::filesystem::path& baseline,
                                const std::string& reason, const std::string& time);

}  // namespace trilat
