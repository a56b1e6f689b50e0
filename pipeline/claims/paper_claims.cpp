// SPDX-License-Identifier: MIT
#include "pipeline/claims/paper_claims.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "evaluators/metrics/statistics.h"
#include "pipeline/claims/embedded_claims.h"
#include "pipeline/claims/error_measures.h"

namespace trilat {
namespace {

// Repetitions whose numbers are errors of joints.
const std::set<std::string> kOfJoints{name_of(PaperStudy::table2), name_of(PaperStudy::table3),
                                      name_of(PaperStudy::sensors)};

void visit_bound(Fields& f, std::optional<ClaimBound>& bound) {
  constexpr std::array kSides{"more_than", "less_than", "within"};
  for (std::size_t side = 0; side < kSides.size(); ++side) {
    std::optional<double> margin;
    f(kSides[side], margin, kMayLack);
    if (!margin) continue;
    bound = ClaimBound{static_cast<ClaimBound::Side>(side), *margin};
  }
}

// Numbers of a repetition; of errors of joints they are of walking and the paper's joints unless they say
// otherwise.
void visit_numbers(Fields& f, const std::string& study, std::vector<ClaimedNumber>& numbers) {
  f("numbers", numbers, kMayLack);
  if (!kOfJoints.contains(study)) return;
  for (ClaimedNumber& number : numbers) {
    if (number.key.condition.empty()) number.key.condition = "walking";
    if (number.key.group.empty()) number.key.group = kPaperJoints;
  }
}

}  // namespace

void ClaimedNumber::fields(ClaimedNumber& self, Fields& f) {
  NumberKey& key = self.key;
  key.measure = "distance";
  key.statistic = "relative_difference";
  f("condition", key.condition, kMayLack);
  f("group", key.group, kMayLack);
  f("method", key.method, kMayLack);
  f("against", key.against, kMayLack);
  f("measure", key.measure, kMayLack);
  f("statistic", key.statistic, kMayLack);
  f("what", self.what, kMayLack);
  f("less_m", self.less, kMayLack);
  visit_bound(f, self.bound);
}

void PaperClaim::fields(PaperClaim& self, Fields& f) {
  f("id", self.id, "where", self.where, "claim", self.text, "printed", self.printed, "why", self.why);
  f("kind", self.kind, kMayLack);
  f("study", self.study, kMayLack);
  visit_bound(f, self.bound);
  visit_numbers(f, self.study, self.numbers);
}

void ErratumEffect::fields(ErratumEffect& self, Fields& f) {
  f("erratum", self.id, "study", self.study);
  visit_numbers(f, self.study, self.numbers);
}

namespace {

struct ClaimsFile {
  std::vector<PaperClaim> claims;
  std::vector<ErratumEffect> effects;

  static void fields(auto& self, auto&& f) { f("claims", self.claims, "effects", self.effects); }
};

const ClaimsFile& claims_file() {
  static const auto file = [] {
    const std::string place = "pipeline/claims/claims.json";
    return read_as<ClaimsFile>(parse_json(embedded::claims_json, place), {place});
  }();
  return file;
}

}  // namespace

std::span<const PaperClaim> paper_claims() { return claims_file().claims; }
std::span<const ErratumEffect> erratum_effects() { return claims_file().effects; }

std::vector<NumberKey> claimed_keys(const std::string& paper) {
  std::vector<NumberKey> keys;
  const auto add = [&](const auto& row) {
    if (row.study == paper)
      for (const ClaimedNumber& number : row.numbers) keys.push_back(number.key);
  };
  std::ranges::for_each(paper_claims(), add);
  std::ranges::for_each(erratum_effects(), add);
  return keys;
}

std::vector<std::string> compared_with(const std::string& paper) {
  std::set<std::string> methods;
  for (const NumberKey& key : claimed_keys(paper))
    if (key.measure == "distance" && !key.against.empty()) methods.insert({kVia, key.against});
  return {methods.begin(), methods.end()};
}

namespace {

// How far a number lies from the margin on the side where the claim holds; below 0 on the other.
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

ClaimPValues p_values_of(const Estimate& e, double scale, const ClaimBound& bound) {
  const double depth = depth_of(scale * e.value, bound);
  if (e.clusters < 2 || !(e.standard_error > 0.0) || !std::isfinite(depth)) return {};
  const double both = student_two_sided(depth / (scale * e.standard_error), e.clusters - 1);
  return depth > 0.0 ? ClaimPValues{both, 1.0} : ClaimPValues{1.0, both};
}

ClaimPValues p_values_of(const ShareEstimate& e, const ClaimBound& bound) {
  const double margin = 0.01 * bound.margin;
  const double more = std::min(1.0, 2.0 * e.chance_of_more(margin)),
               fewer = std::min(1.0, 2.0 * e.chance_of_fewer(margin));
  return bound.side == ClaimBound::Side::more_than ? ClaimPValues{more, fewer} : ClaimPValues{fewer, more};
}

std::string bound_text(const ClaimBound& bound, const std::string& unit) {
  constexpr std::array<const char*, 3> kWords{"more than", "less than", "within"};
  return fmt::format("{} {:g} {}", kWords[static_cast<std::size_t>(bound.side)], bound.margin, unit);
}

// From shares and metres to what is printed.
double scale_of(const std::string& unit) { return unit == "%" || unit == "cm" ? 100.0 : 1.0; }

}  // namespace

ClaimPValues p_values_of(const MeasuredNumber& number, const ClaimBound& bound) {
  constexpr double kPercent = 100.0;
  if (const auto* share = std::get_if<ShareEstimate>(&number)) return p_values_of(*share, bound);
  if (const auto* whole = std::get_if<double>(&number)) {
    const bool holds = depth_of(kPercent * *whole, bound) > 0.0;
    return {holds ? 0.0 : 1.0, holds ? 1.0 : 0.0};
  }
  return p_values_of(std::get<Estimate>(number), kPercent, bound);
}

Estimate estimate_of(const Number& number) {
  Estimate estimate{number.value, kNaN, static_cast<std::size_t>(number.clusters)};
  if (number.clusters > 1 && std::isfinite(number.high))
    estimate.standard_error = (number.high - number.value) / student_quantile(estimate.clusters - 1);
  return estimate;
}

ClaimPValues chance_of_all(const std::vector<ClaimPValues>& numbers) {
  ClaimPValues all{0.0, 1.0};
  for (const ClaimPValues& one : numbers) {
    all.holds = std::max(all.holds, one.holds);
    all.fails = std::min(all.fails, one.fails * static_cast<double>(numbers.size()));
  }
  return numbers.empty() ? ClaimPValues{} : all;
}

ClaimNumber claim_number(const std::string& claim, const Measurement& measured,
                         const std::optional<ClaimBound>& bound) {
  ClaimNumber number{.claim = claim, .what = measured.what, .unit = measured.unit};
  number.missing = measured.missing;
  if (!number.missing.empty()) return number;
  const double scale = scale_of(measured.unit);
  std::visit(
      [&](const auto& e) {
        if constexpr (requires { e.value; }) {
          number.value = scale * e.value;
          number.clusters = e.clusters;
        } else {
          number.value = scale * e;
        }
        if constexpr (requires { e.low(); }) {
          if (e.standard_error > 0.0) number.low = scale * e.low(), number.high = scale * e.high();
        } else if constexpr (requires { e.low; }) {
          number.low = scale * e.low;
          number.high = scale * e.high;
        }
      },
      measured.number);
  number.over = measured.over;
  number.compared = measured.compared;
  if (!bound) return number;
  number.bound = bound_text(*bound, measured.unit);
  const ClaimPValues p_values = p_values_of(measured.number, *bound);
  number.p_holds = p_values.holds;
  number.p_fails = p_values.fails;
  return number;
}

}  // namespace trilat
