// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "datasets/base/document.h"
#include "datasets/results/numbers.h"
#include "pipeline/claims/claim_number.h"

namespace trilat {

// One number of a claim: its key in numbers.csv, to which an accuracy study adds its alignment and a
// calibration study the recording of stated distances as condition.
struct ClaimedNumber {
  NumberKey key;
  std::string what = {};                 // empty: "METHOD against AGAINST, GROUP"
  double less = 0.0;                     // is taken off the value, in SI units
  std::optional<ClaimBound> bound = {};  // instead of the claim's

  static void fields(ClaimedNumber& self, Fields& f);
};

// Which claims count as one of a family of tests.
enum class ClaimKind : std::uint8_t {
  tested,       // its probability is corrected for how many are tested (Holm 1979)
  join_names,   // decided by what is listed whole: no probability
  contradicts,  // by the paper's own numbers
  untestable,   // here; `why` says what would have to be
};
template <>
inline constexpr std::array words<ClaimKind>{"tested", "listed", "contradicts", "untestable"};

struct PaperClaim {
  std::string id, where, text, printed;
  ClaimKind kind = ClaimKind::tested;
  std::string study = {};  // of words<PaperStudy>: the repetition whose results it is judged by
  std::optional<ClaimBound> bound = {};
  std::string why = {};  // this margin
  std::vector<ClaimedNumber> numbers = {};

  static void fields(PaperClaim& self, Fields& f);
};

// Effect of an erratum on errors: the method as printed against the corrected one.
struct ErratumEffect {
  std::string id, study;
  std::vector<ClaimedNumber> numbers;

  static void fields(ErratumEffect& self, Fields& f);
};

// claims.json, which is in the program.
std::span<const PaperClaim> paper_claims();
std::span<const ErratumEffect> erratum_effects();

// The keys of all numbers of claims and errata of such a repetition of the paper.
std::vector<NumberKey> claimed_keys(const std::string& paper);
// The methods that they compare others with.
std::vector<std::string> compared_with(const std::string& paper);

}  // namespace trilat
