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

// The results that what the paper says is held against, as far as there are any. The first of a kind counts.
struct PaperEvidence {
  std::optional<ResultsSummary> walking;      // Table III
  std::optional<ResultsSummary> occluded;     // Table II
  std::vector<ResultsSummary> sensor_counts;  // with "nonlinear, 8 sensors"; one for each rig
  std::optional<SweepSummary> sweep;          // Table I, with the search for readings of it
  std::optional<CalibrationSummary> calibration;
  std::optional<RecordingSummary> recording;  // Table IV

  void add(const ResultsSummary& summary);
  // Whether there is anything of Tables II or III, so that a list of claims says something.
  bool is_of_the_paper() const { return walking.has_value() || occluded.has_value(); }
  // Whether anything here comes from simulated sensors.
  bool any_simulated() const;
};

// Of results folders of any kind. InputError with the place when one holds no results of this version.
PaperEvidence read_paper_evidence(const std::vector<std::filesystem::path>& results);

// A number with its interval over clusters (participants, units, runs); NaN where there is none.
struct ClaimEstimate {
  double value = kNoNumber, low = kNoNumber, high = kNoNumber;
  std::size_t clusters = 0;
  double level_percent = 95.0;
};

// One number that a claim needs, in the claim's unit, "%" or "cm".
struct ClaimPart {
  std::string what;  // "linear against nonlinear, head"
  std::string unit;
  ClaimEstimate estimate;
  std::optional<ClaimEstimate> complete;  // the same over what any of the two methods answers
  std::string bound;                      // "more than 1 %"
};

inline constexpr const char* kHolds = "holds";
inline constexpr const char* kDoesNotHold = "does not hold";
inline constexpr const char* kUndecided = "undecided";
inline constexpr const char* kContradicts = "contradicts itself";
inline constexpr const char* kCannotTest = "cannot be tested here";

// What a claim of the paper comes to.
struct JudgedClaim {
  std::string id, where, claim, printed;
  bool confirmatory = false;  // its chance is corrected for how many are looked at (Holm 1979)
  std::string clusters;       // what its intervals are over: "participants"
  std::string reason;         // why that margin, what is missing, what would decide it
  std::vector<ClaimPart> parts;
  double chance = kNoNumber;  // corrected
  std::string verdict;        // begins with one of the five above: "holds, but a third of the size"
};

struct PaperFindings {
  PaperEvidence evidence;
  std::vector<JudgedClaim> claims;
  std::map<std::string, std::vector<ClaimPart>> errata;  // what an erratum does to errors, by its id
};

}  // namespace trilat
