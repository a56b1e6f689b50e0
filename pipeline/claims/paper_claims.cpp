// SPDX-License-Identifier: MIT
#include "pipeline/claims/paper_claims.h"

#include <algorithm>
#include <array>
#include <set>

#include "datasets/base/strict_json.h"
#include "pipeline/claims/embedded_claims.h"
#include "pipeline/claims/error_measures.h"

namespace trilat {
namespace {

// In the order of the enum.
const std::vector<std::string> kKinds{"tested", "listed", "contradicts", "untestable"};
// Repetitions whose numbers are errors of joints.
const std::set<std::string> kOfJoints{name_of(PaperStudy::table2), name_of(PaperStudy::table3),
                                      name_of(PaperStudy::sensors)};

std::optional<ClaimBound> read_bound(JsonObject& object) {
  constexpr std::array kSides{"more_than", "less_than", "within"};
  std::optional<ClaimBound> bound;
  for (std::size_t side = 0; side < kSides.size(); ++side)
    if (object.has(kSides[side]))
      bound = ClaimBound{static_cast<ClaimBound::Side>(side), object.number(kSides[side])};
  return bound;
}

ClaimedNumber read_number(JsonObject& object, const std::string& study) {
  const bool is_of_joints = kOfJoints.contains(study);
  ClaimedNumber number;
  number.key = {.condition = object.text("condition", is_of_joints ? "walking" : ""),
                .group = object.text("group", is_of_joints ? kPaperJoints : ""),
                .method = object.text("method", ""),
                .against = object.text("against", ""),
                .measure = object.text("measure", "distance"),
                .statistic = object.text("statistic", "relative_difference")};
  number.what = object.text("what", "");
  number.less = object.number("less_m", 0.0);
  number.bound = read_bound(object);
  object.finish();
  return number;
}

std::vector<ClaimedNumber> read_numbers(JsonObject& object, const std::string& study) {
  std::vector<ClaimedNumber> numbers;
  if (object.has("numbers"))
    for (JsonObject& number : object.objects("numbers")) numbers.push_back(read_number(number, study));
  return numbers;
}

PaperClaim read_claim(JsonObject& object) {
  const std::string study = object.text("study", "");
  PaperClaim claim{object.text("id"),
                   object.text("where"),
                   object.text("claim"),
                   object.text("printed"),
                   static_cast<ClaimKind>(object.choice("kind", kKinds, 0)),
                   study,
                   read_bound(object),
                   object.text("why"),
                   read_numbers(object, study)};
  object.finish();
  return claim;
}

struct ClaimsFile {
  std::vector<PaperClaim> claims;
  std::vector<ErratumEffect> effects;
};

const ClaimsFile& claims_file() {
  static const ClaimsFile file = [] {
    const std::string place = "pipeline/claims/claims.json";
    const Json json = parse_json(embedded::claims_json, place);
    JsonObject object(json, place, "");
    ClaimsFile read;
    for (JsonObject& claim : object.objects("claims")) read.claims.push_back(read_claim(claim));
    for (JsonObject& effect : object.objects("effects")) {
      const std::string study = effect.text("study");
      read.effects.push_back({effect.text("erratum"), study, read_numbers(effect, study)});
      effect.finish();
    }
    object.finish();
    return read;
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
