// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "datasets/results/paper_evidence.h"
#include "datasets/results/summary.h"
#include "pipeline/calibration_study/calibration_summary.h"
#include "pipeline/claims/paper_claims.h"
#include "pipeline/clocks/clocks_study.h"
#include "pipeline/sweep/sweep_summary.h"

namespace trilat {

// Probability of any false verdict among all claims that are tested.
inline constexpr double kFalseVerdicts = 0.05;

// A study's numbers for the paper's claims and errata.
std::vector<ClaimNumber> claim_numbers(const ResultsSummary& summary);
std::vector<ClaimNumber> claim_numbers(const SweepSummary& summary);
std::vector<ClaimNumber> claim_numbers(const ClocksSummary& summary);
std::vector<ClaimNumber> claim_numbers(const CalibrationSummary& summary);

// Judges claims by the numbers of studies: every number of a claim has to lie on its side
// of the bound, whichever study it is of. Probabilities are corrected for how many claims are tested (Holm
// 1979).
std::vector<JudgedClaim> judge_claims(std::span<const PaperClaim> claims,
                                      std::span<const ClaimNumber> numbers);

// Every claim and erratum of the paper, judged from results folders; nothing when no study there is of its
// Tables II and III. InputError where two results are of one study.
std::optional<PaperFindings> judge_paper(const std::vector<std::filesystem::path>& results);

}  // namespace trilat
