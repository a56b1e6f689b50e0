// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "pipeline/claims/claim_number.h"
#include "pipeline/claims/error_measures.h"
#include "pipeline/claims/study_measures.h"

namespace trilat {

// How the numbers of a claim come about; monostate: none are needed.
using ClaimMeasure =
    std::variant<std::monostate, Measurements (*)(const ErrorMeasures&),
                 Measurements (*)(const SweepSummary&), Measurements (*)(const ClocksSummary&),
                 Measurements (*)(const CalibrationSummary&)>;

// Which claims count as one of a family of tests.
enum class ClaimKind {
  tested,       // its probability is corrected for how many are tested (Holm 1979)
  listed,       // decided by what is listed whole: no probability
  contradicts,  // by the paper's own numbers
  untestable,   // here; `why` says what would have to be
};

struct PaperClaim {
  const char *id, *where, *text, *printed;
  ClaimKind kind = ClaimKind::tested;
  std::string_view study;  // of kPaperStudies: the repetition whose results it is judged by
  std::optional<ClaimBound> bound;
  const char* why;  // this margin
  ClaimMeasure measure;
};
std::span<const PaperClaim> paper_claims();

// Effect of an erratum on errors: the method as printed against the corrected one.
struct ErratumEffect {
  const char* id;
  std::string_view study;
  ClaimMeasure measure;
};
std::span<const ErratumEffect> erratum_effects();

// The methods that claims and errata compare others with, in such a repetition of the paper.
std::vector<std::string> compared_with(const std::string& paper);

// Every number that a study's results bear on, of claims and errata, as it is stored with them.
std::vector<ClaimNumber> claims_of(const StudyErrors& errors);
std::vector<ClaimNumber> claims_of(const SweepSummary& summary);
std::vector<ClaimNumber> claims_of(const ClocksSummary& summary);
std::vector<ClaimNumber> claims_of(const CalibrationSummary& summary);

}  // namespace trilat
