// SPDX-License-Identifier: MIT
#include "pipeline/claims/paper_claims.h"

#include <algorithm>
#include <array>
#include <set>

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

}  // namespace trilat
