// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "datasets/results/summary.h"
#include "reports/claims.h"

namespace trilat {

// What one claim comes to.
struct ClaimVerdict {
  std::string ours;  // number with interval
  std::string verdict;
  std::string reason;
};

inline constexpr const char* kHolds = "holds";
inline constexpr const char* kDoesNotHold = "does not hold";
inline constexpr const char* kUndecided = "undecided";
inline constexpr const char* kContradicts = "contradicts itself";
inline constexpr const char* kCannotTest = "cannot be tested here";

ClaimVerdict not_run(const std::string& study);

// "5.99 cm (5.70 to 6.20)"; without an interval the number alone.
std::string cell_text(const SummaryCell* cell);
// "worse by 0.38 cm (0.32 to 0.45), 6.4 %", or "better by …": a method against the study's reference, on the
// samples that both answer, in percent of the reference's error.
std::string worse_text(const DifferenceCell* difference);
// "5.11 against 4.02 cm": the errors of a method and of the reference on the samples that both answer.
std::string paired_text(const DifferenceCell* difference);

const DifferenceCell* find_difference(const ResultsSummary& summary, const std::string& method,
                                      const std::string& condition, const std::string& group,
                                      const std::string& alignment);

// Claims about accuracy and occlusion; about the rest.
ClaimVerdict verdict_on_methods(const std::string& claim, const ClaimEvidence& evidence);
ClaimVerdict verdict_on_occlusion(const std::string& claim, const ClaimEvidence& evidence);
ClaimVerdict verdict_on_parts(const std::string& claim, const ClaimEvidence& evidence);

}  // namespace trilat
