// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/base/strict_json.h"
#include "datasets/results/paper_evidence.h"
#include "evaluators/metrics/cluster_ratios.h"

namespace trilat {

// Every claim and erratum of the paper, judged by one rule from results folders; none when nothing there is
// of its Tables II and III.
std::optional<PaperFindings> judge_paper(const std::vector<std::filesystem::path>& results);

// The claims of a document like datasets/paper/claims.json, whose place is `place`; InputError names the
// place in it of what cannot be read.
std::vector<JudgedClaim> judge_claims(const Json& document, const std::string& place,
                                      const PaperEvidence& evidence);

inline constexpr double kFalseVerdicts = 0.05;

// On which side of a margin a number has to lie for a claim to hold: above it, below it, or nearer to zero
// than it.
struct ClaimBound {
  enum class Side { more_than, less_than, within } side = Side::more_than;
  double margin = 0.0;
};

// How likely an estimate this far on its side of the margin would be if the truth lay on the other side:
// twice the one-sided probability by Student's t, so that 0.05 is where the 95 % interval touches the margin.
// 1 when there is no standard error.
struct ClaimChance {
  double holds = 1.0, fails = 1.0;
  double decided() const { return holds < fails ? holds : fails; }
};
ClaimChance chance_of(const ContrastEstimate& estimate, const ClaimBound& bound);

// A claim of several parts holds when all do (the largest of their chances: Berger 1982) and fails when one
// does (the smallest, times their number).
ClaimChance chance_of_all(const std::vector<ClaimChance>& parts);

// How many clusters would decide it in four of five repetitions if the truth were the estimate and clusters
// differed as these do; none when even 10,000 would not.
std::optional<std::size_t> clusters_needed(const ContrastEstimate& estimate, const ClaimBound& bound,
                                           double chance);

// "a third of the size" when the whole interval of the ratio to the paper's effect lies outside of 0.8 to
// 1.25, the usual limits of equivalence; empty when it does not.
std::string size_beside(const ClaimEstimate& estimate, double paper);

}  // namespace trilat
