// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pipeline/claims/claim_number.h"
#include "pipeline/claims/error_measures.h"
#include "pipeline/claims/study_measures.h"

namespace trilat {

// A measure that claims are judged by; the kind of study that has it stands in brackets.
enum class ClaimMeasure : std::uint8_t {
  difference,            // of a method's error from another's (accuracy)
  place,                 // of a method's error at one place from that at another (accuracy)
  abrupt,                // of nonlinear's error where joints accelerate more (accuracy)
  clock_cost,            // how far a joint goes in that time, in shares of the error (accuracy)
  largest_wrist_height,  // of a take (accuracy)
  wrist_height,          // mean error (accuracy)
  interpretations,       // of Table I that are acceptable (threshold sweep)
  share,                 // over recordings and sensors, by its key in numbers.csv (clocks)
  wand_distance,         // mean error in a zone, or against another zone (calibration)
};

// One number of a claim.
struct ClaimedNumber {
  ClaimMeasure measure = ClaimMeasure::difference;
  std::string method = {}, against = {};
  ErrorPlace at = {}, other = {};
  NumberKey key = {};  // of a share
  double seconds = 0.0;
  WandZone zone = {};
  std::optional<WandZone> other_zone = {};
  double less_m = 0.0;
  std::optional<ClaimBound> bound = {};  // instead of the claim's
};

// Which claims count as one of a family of tests.
enum class ClaimKind : std::uint8_t {
  tested,       // its probability is corrected for how many are tested (Holm 1979)
  listed,       // decided by what is listed whole: no probability
  contradicts,  // by the paper's own numbers
  untestable,   // here; `why` says what would have to be
};

struct PaperClaim {
  std::string id, where, text, printed;
  ClaimKind kind = ClaimKind::tested;
  std::string study = {};  // of kPaperStudies: the repetition whose results it is judged by
  std::optional<ClaimBound> bound = {};
  std::string why = {};  // this margin
  std::vector<ClaimedNumber> numbers = {};
};

// Effect of an erratum on errors: the method as printed against the corrected one.
struct ErratumEffect {
  std::string id, study;
  std::vector<ClaimedNumber> numbers;
};

// claims.json, which is in the program.
std::span<const PaperClaim> paper_claims();
std::span<const ErratumEffect> erratum_effects();

// The methods that claims and errata compare others with, in such a repetition of the paper.
std::vector<std::string> compared_with(const std::string& paper);

// Every number that a study's results bear on, of claims and errata, as it is stored with them.
std::vector<ClaimNumber> claims_of(const StudyErrors& errors);
std::vector<ClaimNumber> claims_of(const SweepSummary& summary);
std::vector<ClaimNumber> claims_of(const ClocksSummary& summary);
std::vector<ClaimNumber> claims_of(const std::string& paper, const CalibrationRecordings& recordings);

}  // namespace trilat
