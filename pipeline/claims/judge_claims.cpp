// SPDX-License-Identifier: MIT
#include "pipeline/claims/judge_claims.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/paper/printed_tables.h"
#include "evaluators/metrics/student.h"
#include "pipeline/claims/measures.h"

namespace trilat {
namespace {

// A claim with the numbers that it is decided by.
struct OpenClaim {
  struct Part {
    Measurement measured;
    ClaimBound bound;
    std::optional<double> paper;  // the paper's own, where it prints one
    ClaimChance chance;
  };
  JudgedClaim judged;
  std::vector<Part> parts;
};

constexpr std::array<const char*, 3> kBounds{"more_than", "less_than", "within"};

std::optional<ClaimBound> read_bound(JsonObject& object) {
  std::optional<ClaimBound> bound;
  for (std::size_t k = 0; k < kBounds.size(); ++k) {
    if (!object.has(kBounds[k])) continue;
    if (bound) object.refuse(kBounds[k], "is a second bound; one is enough");
    bound = ClaimBound{static_cast<ClaimBound::Side>(k), object.number(kBounds[k])};
  }
  return bound;
}

std::string bound_text(const ClaimBound& bound, const std::string& unit) {
  constexpr std::array<const char*, 3> kWords{"more than", "less than", "within"};
  return fmt::format("{} {:g} {}", kWords[static_cast<std::size_t>(bound.side)], bound.margin, unit);
}

ClaimEstimate estimate_of(const ContrastEstimate& e, double alpha = kFalseVerdicts) {
  const bool is_sampled = e.standard_error > 0.0;
  return {e.value, is_sampled ? e.low(alpha) : kNoNumber, is_sampled ? e.high(alpha) : kNoNumber, e.clusters,
          100.0 * (1.0 - alpha)};
}

ClaimPart part_of(const Measurement& measured, const std::string& bound) {
  ClaimPart part{measured.what, measured.unit, estimate_of(measured.estimate), {}, bound};
  if (measured.complete) part.complete = estimate_of(*measured.complete);
  return part;
}

// How far the estimate lies from the margin on the side where the claim holds; below 0 on the other.
double depth_of(double value, const ClaimBound& bound) {
  switch (bound.side) {
    case ClaimBound::Side::more_than:
      return value - bound.margin;
    case ClaimBound::Side::less_than:
      return bound.margin - value;
    case ClaimBound::Side::within:
      return bound.margin - std::abs(value);
  }
  return kNaN;
}

// Takes a claim's parts in; what is missing of them, or nothing.
std::string measure_parts(JsonObject& row, const ClaimStudies& studies, OpenClaim& claim, bool& contradicts) {
  const std::optional<ClaimBound> usual = read_bound(row);
  std::string missing;
  for (JsonObject& entry : row.objects("parts")) {
    const std::optional<ClaimBound> own = read_bound(entry);
    std::optional<double> paper;
    if (entry.has("paper")) paper = entry.number("paper");
    MeasuredPart measured = measure(entry, studies);
    entry.finish();
    contradicts |= measured.contradicts;
    if (!measured.missing.empty()) missing = measured.missing;
    if (!measured.parts.empty() && !own && !usual)
      entry.refuse("statistic", "needs a bound: more_than, less_than or within");
    claim.judged.clusters = measured.clusters;
    for (const Measurement& part : measured.parts) {
      const ClaimBound bound = own ? *own : *usual;
      claim.parts.push_back({part, bound, paper, chance_of(part.estimate, bound)});
      claim.judged.parts.push_back(part_of(part, bound_text(bound, part.unit)));
    }
  }
  return missing;
}

OpenClaim read_claim(JsonObject& row, const ClaimStudies& studies) {
  OpenClaim claim;
  JudgedClaim& judged = claim.judged;
  judged.id = row.text("id");
  judged.where = row.text("where");
  judged.claim = row.text("claim");
  judged.printed = row.text("printed");
  judged.confirmatory = row.boolean("confirmatory", false);
  judged.reason = row.text("because", "");
  bool contradicts = false;
  const std::string missing = measure_parts(row, studies, claim, contradicts);
  row.finish();
  if (contradicts) {
    judged.verdict = kContradicts;
    judged.reason = "by the paper's own numbers: see the audit";
  } else if (!missing.empty()) {
    judged.verdict = kCannotTest;
    judged.confirmatory = false;
    judged.reason = missing;
    judged.parts.clear();
    claim.parts.clear();
  }
  return claim;
}

ClaimChance chance_of(const OpenClaim& claim) {
  std::vector<ClaimChance> chances;
  for (const OpenClaim::Part& part : claim.parts) chances.push_back(part.chance);
  return chance_of_all(chances);
}

std::string needed_text(const OpenClaim& claim, double alpha) {
  const OpenClaim::Part& weakest = *std::ranges::max_element(claim.parts, [](const auto& a, const auto& b) {
    return a.chance.holds - a.chance.fails < b.chance.holds - b.chance.fails;
  });
  const ContrastEstimate& e = weakest.measured.estimate;
  if (const auto needed = clusters_needed(e, weakest.bound, alpha))
    return fmt::format("; some {} {} would decide it, here are {}", *needed, claim.judged.clusters,
                       e.clusters);
  return fmt::format("; not even 10,000 {} would decide it", claim.judged.clusters);
}

// Words behind "holds": it may hold only where both answer, or by another size than the paper's.
std::string reservations(const OpenClaim& claim, double alpha) {
  std::string words, size;
  for (std::size_t k = 0; k < claim.parts.size(); ++k) {
    const OpenClaim::Part& part = claim.parts[k];
    if (const auto& complete = part.measured.complete;
        complete && chance_of(*complete, part.bound).holds > alpha)
      words = ", where both answer";
    if (part.paper && size.empty()) size = size_beside(claim.judged.parts[k].estimate, *part.paper);
  }
  return size.empty() ? words : words + ", but " + size;
}

// Each number's interval at the level that its verdict is decided by: a claim of n numbers holds when all n
// lie on their side at `alpha`, and fails when one lies on the other at `alpha` / n.
void show_intervals(OpenClaim& claim, double alpha) {
  for (std::size_t k = 0; k < claim.parts.size(); ++k) {
    const auto& measured = claim.parts[k].measured;
    const auto shown = [&](const ContrastEstimate& e) {
      const bool on_its_side = !(depth_of(e.value, claim.parts[k].bound) < 0.0);
      return estimate_of(e, on_its_side ? alpha : alpha / static_cast<double>(claim.parts.size()));
    };
    ClaimPart& part = claim.judged.parts[k];
    part.estimate = shown(measured.estimate);
    if (measured.complete) part.complete = shown(*measured.complete);
  }
}

// The verdict at the level `alpha`.
void decide(OpenClaim& claim, double alpha) {
  const ClaimChance chance = chance_of(claim);
  JudgedClaim& judged = claim.judged;
  show_intervals(claim, alpha);
  if (!(chance.decided() <= alpha)) {
    judged.verdict = kUndecided;
    judged.reason += needed_text(claim, alpha);
  } else if (chance.fails < chance.holds) {
    judged.verdict = kDoesNotHold;
  } else {
    judged.verdict = kHolds + reservations(claim, alpha);
  }
}

constexpr double kPower80 = 0.8416212335729143;  // quantile of the normal distribution at 80 %
constexpr std::size_t kMostClusters = 10'000;

// Twice the probability that Student's t is at least this.
double twice_above(double t, std::size_t degrees) {
  const double both = student_two_sided(t, degrees);
  return t > 0.0 ? both : 2.0 - both;
}

}  // namespace

std::vector<JudgedClaim> judge_claims(const Json& rows, const std::string& place,
                                      const PaperEvidence& evidence) {
  JsonObject document(rows, place, "");
  document.text("source");
  const ClaimStudies studies(evidence);
  std::vector<OpenClaim> claims;
  for (JsonObject& row : document.objects("claims")) claims.push_back(read_claim(row, studies));
  document.finish();
  std::vector<double> chances;
  for (const OpenClaim& claim : claims)
    chances.push_back(claim.judged.confirmatory ? chance_of(claim).decided() : kNaN);
  const std::vector<double> corrected = holm_adjusted(chances), levels = holm_levels(chances, kFalseVerdicts);
  std::vector<JudgedClaim> judged;
  for (std::size_t k = 0; k < claims.size(); ++k) {
    OpenClaim& claim = claims[k];
    const bool is_corrected = claim.judged.confirmatory;
    if (!claim.parts.empty()) {
      claim.judged.chance = is_corrected ? corrected[k] : chance_of(claim).decided();
      decide(claim, is_corrected ? levels[k] : kFalseVerdicts);
    }
    judged.push_back(std::move(claim.judged));
  }
  return judged;
}

std::optional<PaperFindings> judge_paper(const std::vector<std::filesystem::path>& results) {
  PaperFindings findings{read_paper_evidence(results), {}, {}};
  if (!findings.evidence.is_of_the_paper()) return std::nullopt;
  findings.claims = judge_claims(printed_claims(), "datasets/paper/claims.json", findings.evidence);
  const ClaimStudies studies(findings.evidence);
  for (const PrintedErrata::Erratum& erratum : printed_errata().errata) {
    if (!erratum.effect) continue;
    JsonObject effect(*erratum.effect, "datasets/paper/errata.json", "/" + erratum.id);
    for (const Measurement& measured : measure(effect, studies).parts)
      findings.errata[erratum.id].push_back(part_of(measured, ""));
    effect.finish();
  }
  return findings;
}

ClaimChance chance_of(const ContrastEstimate& e, const ClaimBound& bound) {
  const double depth = depth_of(e.value, bound);
  if (e.clusters < 2 || !std::isfinite(e.standard_error) || !std::isfinite(depth) || depth == 0.0) return {};
  const double t = depth / e.standard_error;
  return {std::min(1.0, twice_above(t, e.clusters - 1)), std::min(1.0, twice_above(-t, e.clusters - 1))};
}

ClaimChance chance_of_all(const std::vector<ClaimChance>& parts) {
  ClaimChance all{0.0, 1.0};
  for (const ClaimChance& part : parts) {
    all.holds = std::max(all.holds, part.holds);
    all.fails = std::min(all.fails, part.fails * static_cast<double>(parts.size()));
  }
  return parts.empty() ? ClaimChance{} : all;
}

std::optional<std::size_t> clusters_needed(const ContrastEstimate& e, const ClaimBound& bound,
                                           double chance) {
  const double depth = std::abs(depth_of(e.value, bound));
  if (e.clusters < 2 || !std::isfinite(depth) || !(e.standard_error > 0.0)) return std::nullopt;
  const double spread = e.standard_error * std::sqrt(static_cast<double>(e.clusters));
  const auto enough = [&](std::size_t n) {
    return twice_above(depth * std::sqrt(static_cast<double>(n)) / spread - kPower80, n - 1) <= chance;
  };
  if (!enough(kMostClusters)) return std::nullopt;
  std::size_t no = 1, yes = kMostClusters;
  while (yes - no > 1) {
    const std::size_t middle = no + (yes - no) / 2;
    (enough(middle) ? yes : no) = middle;
  }
  return yes;
}

std::string size_beside(const ClaimEstimate& e, double paper) {
  const double ratio = e.value / paper;
  const auto [low, high] = std::minmax({e.low / paper, e.high / paper});
  if (low > 1.25) return fmt::format("{:.1f} times the size", ratio);
  if (!(ratio > 0.0 && high < 0.8)) return {};
  constexpr std::array<std::pair<double, const char*>, 7> kWords{{{0.1, "a tenth"},
                                                                  {0.2, "a fifth"},
                                                                  {0.25, "a quarter"},
                                                                  {1.0 / 3.0, "a third"},
                                                                  {0.5, "half"},
                                                                  {2.0 / 3.0, "two thirds"},
                                                                  {0.75, "three quarters"}}};
  if (ratio < 0.07) return fmt::format("{:.1g} % of the size", 100.0 * ratio);
  const auto nearest = std::ranges::min_element(kWords, [&](const auto& a, const auto& b) {
    return std::abs(a.first - ratio) < std::abs(b.first - ratio);
  });
  return std::string(nearest->second) + " of the size";
}

}  // namespace trilat
