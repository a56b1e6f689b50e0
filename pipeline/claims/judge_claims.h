// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "datasets/results/paper_evidence.h"
#include "pipeline/claims/paper_claims.h"

namespace trilat {

// The chance of a false verdict among all claims that are tested.
inline constexpr double kFalseVerdicts = 0.05;

// Judges claims by the numbers that studies stored for them: every number of a claim has to lie on its side
// of the bound, whichever study it is of. Probabilities are corrected for how many claims are tested (Holm
// 1979).
std::vector<JudgedClaim> judge_claims(std::span<const PaperClaim> claims,
                                      std::span<const ClaimNumber> numbers);

// Every claim and erratum of the paper, judged from results folders; nothing when no study there is of its
// Tables II and III. InputError where two results are of one study.
std::optional<PaperFindings> judge_paper(const std::vector<std::filesystem::path>& results);

}  // namespace trilat
