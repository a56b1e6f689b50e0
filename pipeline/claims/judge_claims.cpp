// SPDX-License-Identifier: MIT
#include "pipeline/claims/judge_claims.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "evaluators/metrics/statistics.h"
#include "pipeline/claims/error_measures.h"

namespace trilat {
namespace {

constexpr const char* kRuns = "recordings of a sensor";
constexpr const char* kUnits = "sensors";

std::string what_of(const ClaimedNumber& number) {
  if (!number.what.empty()) return number.what;
  const NumberKey& key = number.key;
  return fmt::format("{} against {}{}", key.method, key.against,
                     key.group == kPaperJoints ? "" : ", " + key.group);
}

Measurement measured(const ClaimedNumber& claimed, const Number& number) {
  Estimate estimate = estimate_of(number);
  estimate.value -= claimed.less;
  return {.what = what_of(claimed), .unit = unit_of(number) == "m" ? "cm" : "%", .number = estimate};
}
Measurement lacking(std::string what) { return {.missing = std::move(what)}; }

// The methods of a name: of a family, of "best of FAMILY", or itself.
std::vector<std::string> methods_named(const ResultsSummary& s, const std::string& name) {
  if (name.starts_with(kBestOf)) return methods_named(s, name.substr(kBestOf.size()));
  const auto family = std::ranges::find(s.families, name, &SensorSetGroup::name);
  if (family != s.families.end()) return family->methods;
  const bool is_there = std::ranges::find(s.methods, name) != s.methods.end();
  return is_there ? std::vector{name} : std::vector<std::string>{};
}

// Why a study lacks a number of that key.
std::string lack_of(const ResultsSummary& s, const NumberKey& key) {
  if (s.left_out()) return "motion capture: differences from a sensor are no errors";
  std::vector<std::string> names{key.method};
  if (key.measure == "distance") names.push_back(key.against);
  for (const std::string& name : names)
    if (methods_named(s, name).empty()) return fmt::format("a study with {}", name);
  const std::vector<std::string> joints = printed_groups(key.condition);
  if (!std::ranges::all_of(
          joints,
          [&](const std::string& group) { return std::ranges::find(s.groups, group) != s.groups.end(); }) ||
      std::ranges::find(s.conditions, key.condition) == s.conditions.end())
    return fmt::format("a study of {} with the joints of {}", key.condition, fmt::join(joints, ", "));
  for (const std::string& name : names)
    if (std::ranges::none_of(methods_named(s, name), [&](const std::string& method) {
          return std::ranges::any_of(s.groups, [&](const std::string& group) {
            return coverage_of(s, method, key.condition, group, s.alignments.front()) > 0.0;
          });
        }))
      return fmt::format("{} answers nothing on the rig of {}", name, s.campaign);
  return key.method.starts_with(kBestOf) ? "more than one participant"
                                         : fmt::format("samples that {} answer", fmt::join(names, " and "));
}

Measurement find(const ResultsSummary& s, const ClaimedNumber& claimed) {
  const NumberKey key = claimed.key.with({.alignment = s.alignments.front()});
  const Number* number = s.numbers.find(key);
  if (!number) return lacking(lack_of(s, key));
  Measurement found = measured(claimed, *number);
  found.compared = s.numbers.value(key.with({.statistic = "share_compared"}));
  const auto clusters = s.clusters.find(key.condition);
  if (clusters != s.clusters.end()) found.over = clusters->second;
  return found;
}

// A list of all has no interval.
Measurement find(const SweepSummary& s, const ClaimedNumber& claimed) {
  const Number* number = s.numbers.find(claimed.key);
  if (!number)
    return lacking(s.numbers.find(claimed.key.with({.statistic = "share_near"}))
                       ? "an interpretation of Table I whose every error is that near the printed one"
                       : "a sweep over the thresholds and error ranges of Table I");
  return {.what = fmt::format("of {} acceptable interpretations of {}", number->n, s.interpretations()),
          .unit = "%",
          .number = number->value,
          .over = "interpretations, all of them listed"};
}

// A share over recordings and sensors, each of which is a cluster with a number of its own.
Measurement find(const ClocksSummary& s, const ClaimedNumber& claimed) {
  const NumberKey& key = claimed.key;
  std::vector<double> part, whole;
  for (const Number& unit : s.numbers.all()) {
    if (unit.take.empty() || unit.with(key) != unit) continue;
    part.push_back(std::round(unit.value * static_cast<double>(unit.n)));
    whole.push_back(static_cast<double>(unit.n));
  }
  if (whole.empty())
    return lacking(
        fmt::format("a study of clocks with {} of {}, {}", key.statistic, key.measure, key.method));
  return {.what = s.campaign, .unit = "%", .number = estimate_share(part, whole), .over = kRuns};
}

Measurement find(const CalibrationSummary& s, const ClaimedNumber& claimed) {
  const Number* number = s.numbers.find(claimed.key.with({.condition = s.stated_distances}));
  if (s.stated_distances.empty() || !number)
    return lacking("a calibration study with a ball at stated distances");
  Measurement found = measured(claimed, *number);
  found.over = kUnits;
  return found;
}

// The numbers of every claim and erratum that such a repetition of the paper measures.
std::vector<ClaimNumber> numbers_in(const auto& summary) {
  std::vector<ClaimNumber> numbers;
  const auto add = [&](const auto& row, const std::optional<ClaimBound>& bound) {
    if (row.study != summary.paper) return;
    for (const ClaimedNumber& number : row.numbers)
      numbers.push_back(claim_number(row.id, find(summary, number), number.bound ? number.bound : bound));
  };
  for (const PaperClaim& claim : paper_claims()) add(claim, claim.bound);
  for (const ErratumEffect& effect : erratum_effects()) add(effect, std::nullopt);
  return numbers;
}

std::vector<ClaimNumber> numbers_of_results(StudyKind kind, const std::filesystem::path& folder) {
  switch (kind) {
    case StudyKind::accuracy:
      return claim_numbers(read_results<ResultsSummary>(folder));
    case StudyKind::threshold_sweep:
      return claim_numbers(read_results<SweepSummary>(folder));
    case StudyKind::calibration:
      return claim_numbers(read_results<CalibrationSummary>(folder));
    case StudyKind::clocks:
      return claim_numbers(read_results<ClocksSummary>(folder));
  }
  return {};
}

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

ClaimPValues p_values_of(const JudgedClaim& claim) {
  std::vector<ClaimPValues> p_values;
  for (const ClaimNumber& number : claim.numbers) p_values.push_back({number.p_holds, number.p_fails});
  return chance_of_all(p_values);
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

std::vector<ClaimNumber> claim_numbers(const ResultsSummary& summary) { return numbers_in(summary); }
std::vector<ClaimNumber> claim_numbers(const SweepSummary& summary) { return numbers_in(summary); }
std::vector<ClaimNumber> claim_numbers(const ClocksSummary& summary) { return numbers_in(summary); }
std::vector<ClaimNumber> claim_numbers(const CalibrationSummary& summary) { return numbers_in(summary); }

std::vector<JudgedClaim> judge_claims(std::span<const PaperClaim> claims,
                                      std::span<const ClaimNumber> numbers) {
  std::vector<JudgedClaim> judged;
  std::vector<double> p_values;
  for (const PaperClaim& claim : claims) {
    judged.push_back(claim_with(claim, numbers));
    const bool is_tested = claim.kind == ClaimKind::tested && !judged.back().numbers.empty();
    p_values.push_back(is_tested ? p_values_of(judged.back()).decided() : kNaN);
  }
  const std::vector<double> corrected = holm_adjusted(p_values);
  for (std::size_t k = 0; k < judged.size(); ++k) {
    if (judged[k].numbers.empty()) continue;
    const ClaimPValues of_claim = p_values_of(judged[k]);
    const double decided = std::isnan(corrected[k]) ? of_claim.decided() : corrected[k];
    judged[k].p = corrected[k];
    judged[k].verdict = !(decided <= kFalseVerdicts)      ? ClaimVerdict::undecided
                        : of_claim.fails < of_claim.holds ? ClaimVerdict::does_not_hold
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
  std::vector<ClaimNumber> numbers;
  for (const std::filesystem::path& folder : results)
    if (const ResultsHead head = read_results_head(folder); head.paper != name_of(PaperStudy::none))
      for (ClaimNumber& number : numbers_of_results(head.kind, folder)) numbers.push_back(std::move(number));
  findings.claims = judge_claims(paper_claims(), numbers);
  for (const ErratumEffect& effect : erratum_effects())
    for (const ClaimNumber& number : numbers)
      if (number.claim == effect.id && number.missing.empty()) findings.errata[effect.id].push_back(number);
  return findings;
}

}  // namespace trilat
