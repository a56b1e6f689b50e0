// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "datasets/results/studies/calibration_summary.h"
#include "datasets/results/studies/recording_summary.h"
#include "datasets/results/studies/sweep_summary.h"
#include "datasets/results/summary.h"

namespace trilat {

// The results that what the paper says is held against, as far as there are any: each by the name of its
// study.
struct PaperEvidence {
  std::optional<ResultsSummary> walking;      // table3
  std::optional<ResultsSummary> occluded;     // table2
  std::vector<ResultsSummary> sensor_counts;  // sensors_RIG, one for each rig
  std::optional<SweepSummary> sweep;          // table1_search
  std::optional<CalibrationSummary> calibration;
  std::optional<RecordingSummary> recording;  // table4

  // Whether there is anything of Tables II or III, so that a list of claims says something.
  bool is_of_the_paper() const { return walking.has_value() || occluded.has_value(); }
  // Whether anything here comes from simulated sensors.
  bool any_simulated() const;
  // All numbers that the studies stored for the paper's claims.
  std::vector<ClaimNumber> claims() const;
};

// Of results folders of any kind. InputError with the place when one holds no results of this version, or two
// are of one study: it would depend on their order which of them counts.
PaperEvidence read_paper_evidence(const std::vector<std::filesystem::path>& results);

struct PaperFindings {
  PaperEvidence evidence;
  std::vector<JudgedClaim> claims;
  std::map<std::string, std::vector<ClaimNumber>> errata;  // what an erratum does to errors, by its id
};

}  // namespace trilat
