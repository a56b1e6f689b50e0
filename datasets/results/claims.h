// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "datasets/base/document.h"
#include "datasets/base/units.h"
#include "datasets/results/results_file.h"

namespace trilat {

// One number that a claim or an erratum of the paper is judged by, as the numbers of a study give it. NaN
// where there is none.
struct ClaimNumber {
  std::string claim = {};                        // its id: "better_than_linear", "E7"
  std::string what = {};                         // "linear against nonlinear, head"
  std::string unit = {};                         // "%" or "cm"
  double value = kNaN, low = kNaN, high = kNaN;  // 95 %
  std::uint64_t clusters = 0;
  std::string over = {};   // what the interval is over: "participants"
  double compared = kNaN;  // of two methods: the share of the samples that both answer
  std::string bound = {};  // "more than 1 %"; empty where nothing is decided
  // The probabilities of a number so far on its side of the bound (or on the other) by chance, twice the
  // one-sided ones: 0.05 is where the 95 % interval touches the bound. Of what was not sampled but listed
  // whole, 0 or 1.
  double p_holds = kNaN, p_fails = kNaN;
  std::string missing = {};  // why there is no number
};

enum class ClaimVerdict : std::uint8_t { holds, does_not_hold, undecided, contradicts, cannot_test };
inline constexpr std::array kVerdictNames{"holds", "does not hold", "undecided", "contradicts itself",
                                          "cannot be tested here"};
inline const char* name_of(ClaimVerdict verdict) {
  return kVerdictNames.at(static_cast<std::size_t>(verdict));
}

// Judgement of a claim of the paper.
struct JudgedClaim {
  std::string id, where, claim, printed;
  std::string reason;  // why that margin, or why there is no verdict
  std::vector<ClaimNumber> numbers;
  double p = kNaN;  // corrected for how many claims are tested (Holm 1979)
  ClaimVerdict verdict = ClaimVerdict::cannot_test;
};

}  // namespace trilat
