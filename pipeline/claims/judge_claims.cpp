// SPDX-License-Identifier: MIT
#include "pipeline/claims/judge_claims.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "evaluators/metrics/statistics.h"

namespace trilat {
namespace {

JudgedClaim claim_with(const PaperClaim& claim, std::span<const ClaimNumber> numbers) {
  JudgedClaim judged{claim.id, claim.where, claim.text, claim.printed, claim.why, {}, kNaN};
  if (claim.kind == ClaimKind::contradicts || claim.kind == ClaimKind::untestable) {
    judged.verdict =
        claim.kind == ClaimKind::contradicts ? ClaimVerdict::contradicts : ClaimVerdict::cannot_test;
    return judged;
  }
  std::string missing;
  for (const ClaimNumber& number : numbers) {
    if (number.claim != claim.id) continue;
    if (number.missing.empty())
      judged.numbers.push_back(number);
    else
      missing = number.missing;
  }
  if (!missing.empty()) judged.numbers.clear();
  if (!judged.numbers.empty()) return judged;
  judged.verdict = ClaimVerdict::cannot_test;
  judged.reason =
      "needs " + (missing.empty() ? fmt::format("results of the study {}", claim.study) : missing);
  return judged;
}

ClaimChance chance_of(const JudgedClaim& claim) {
  std::vector<ClaimChance> chances;
  for (const ClaimNumber& number : claim.numbers) chances.push_back({number.p_holds, number.p_fails});
  return chance_of_all(chances);
}

// Why an undecided claim of a share near all could not hold, however good the shares were; empty where it
// could. With no spread between the clusters each counts as one trial.
std::string too_few_clusters(const PaperClaim& claim, const JudgedClaim& judged) {
  if (!claim.bound || claim.bound->side != ClaimBound::Side::more_than) return "";
  for (const ClaimNumber& number : judged.numbers) {
    const double share = claim.bound->margin / 100.0;
    if (number.unit != "%" || !(share > 0.5 && share < 1.0)) continue;
    const double best_p = 2.0 * std::pow(share, static_cast<double>(number.clusters));
    const double needed = std::log(kFalseVerdicts / 2.0) / std::log(share);
    if (best_p > kFalseVerdicts)
      return fmt::format(
          "{} {} cannot show more than {:g} %: {:.0f} would be needed; the interval is what is known",
          number.clusters, number.over, claim.bound->margin, std::ceil(needed));
  }
  return "";
}

}  // namespace

std::vector<JudgedClaim> judge_claims(std::span<const PaperClaim> claims,
                                      std::span<const ClaimNumber> numbers) {
  std::vector<JudgedClaim> judged;
  std::vector<double> chances;
  for (const PaperClaim& claim : claims) {
    judged.push_back(claim_with(claim, numbers));
    const bool is_tested = claim.kind == ClaimKind::tested && !judged.back().numbers.empty();
    chances.push_back(is_tested ? chance_of(judged.back()).decided() : kNaN);
  }
  const std::vector<double> corrected = holm_adjusted(chances);
  for (std::size_t k = 0; k < judged.size(); ++k) {
    if (judged[k].numbers.empty()) continue;
    const ClaimChance chance = chance_of(judged[k]);
    const double decided = std::isnan(corrected[k]) ? chance.decided() : corrected[k];
    judged[k].p = corrected[k];
    judged[k].verdict = !(decided <= kFalseVerdicts)  ? ClaimVerdict::undecided
                        : chance.fails < chance.holds ? ClaimVerdict::does_not_hold
                                                      : ClaimVerdict::holds;
    if (judged[k].verdict != ClaimVerdict::undecided) continue;
    if (std::string too_few = too_few_clusters(claims[k], judged[k]); !too_few.empty()) {
      judged[k].reason = std::move(too_few);
      judged[k].verdict = ClaimVerdict::cannot_test;
    }
  }
  return judged;
}

std::optional<PaperFindings> judge_paper(const std::vector<std::filesystem::path>& results) {
  PaperFindings findings{read_paper_evidence(results), {}, {}};
  if (!findings.evidence.is_of_the_paper) return std::nullopt;
  const std::vector<ClaimNumber>& numbers = findings.evidence.claims;
  findings.claims = judge_claims(paper_claims(), numbers);
  for (const ErratumEffect& effect : erratum_effects())
    for (const ClaimNumber& number : numbers)
      if (number.claim == effect.id && number.missing.empty()) findings.errata[effect.id].push_back(number);
  return findings;
}

}  // namespace trilat
