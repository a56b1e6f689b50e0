// SPDX-License-Identifier: MIT
#include "pipeline/claims/paper_claims.h"

#include <array>
#include <set>

#include "datasets/base/strict_json.h"
#include "pipeline/claims/embedded_claims.h"

namespace trilat {
namespace {

// In the order of the enums.
const std::vector<std::string> kMeasures{
    "difference",   "place",           "abrupt", "clock_cost",   "largest_wrist_height",
    "wrist_height", "interpretations", "share",  "wand_distance"};
const std::vector<std::string> kKinds{"tested", "listed", "contradicts", "untestable"};

std::optional<ClaimBound> read_bound(JsonObject& object) {
  constexpr std::array kSides{"more_than", "less_than", "within"};
  std::optional<ClaimBound> bound;
  for (std::size_t side = 0; side < kSides.size(); ++side)
    if (object.has(kSides[side]))
      bound = ClaimBound{static_cast<ClaimBound::Side>(side), object.number(kSides[side])};
  return bound;
}

std::array<double, 2> read_pair(JsonObject& object, const std::string& key) {
  const std::vector<double> pair = object.numbers(key, 2);
  return {pair[0], pair[1]};
}

ClaimedNumber read_number(JsonObject& object) {
  ClaimedNumber number;
  number.measure = static_cast<ClaimMeasure>(object.choice("measure", kMeasures, 0));
  number.method = object.text("method", "");
  number.against = object.text("against", "");
  number.at = {object.text("condition", "walking"), object.text("group", "")};
  number.other = {object.text("other_condition", "walking"), object.text("other_group", "")};
  if (number.measure == ClaimMeasure::share)
    number.key = {.condition = object.text("condition", ""),
                  .method = number.method,
                  .measure = object.text("of"),
                  .statistic = object.text("statistic")};
  number.seconds = object.number("seconds", 0.0);
  if (object.has("distance_m"))
    number.zone = {read_pair(object, "distance_m"), read_pair(object, "angle_deg")};
  if (object.has("other_distance_m"))
    number.other_zone = {read_pair(object, "other_distance_m"), read_pair(object, "other_angle_deg")};
  number.less_m = object.number("less_m", 0.0);
  number.bound = read_bound(object);
  object.finish();
  return number;
}

std::vector<ClaimedNumber> read_numbers(JsonObject& object) {
  std::vector<ClaimedNumber> numbers;
  if (object.has("numbers"))
    for (JsonObject& number : object.objects("numbers")) numbers.push_back(read_number(number));
  return numbers;
}

PaperClaim read_claim(JsonObject& object) {
  PaperClaim claim{object.text("id"),
                   object.text("where"),
                   object.text("claim"),
                   object.text("printed"),
                   static_cast<ClaimKind>(object.choice("kind", kKinds, 0)),
                   object.text("study", ""),
                   read_bound(object),
                   object.text("why"),
                   read_numbers(object)};
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
      read.effects.push_back({effect.text("erratum"), effect.text("study"), read_numbers(effect)});
      effect.finish();
    }
    object.finish();
    return read;
  }();
  return file;
}

// Measures a number on a study's results; nothing where another kind of study measures it.
std::optional<Measurement> measure(const ClaimedNumber& number, const ErrorMeasures& errors) {
  switch (number.measure) {
    case ClaimMeasure::difference:
      return errors.difference(number.method, number.against, number.at);
    case ClaimMeasure::place:
      return errors.places(number.method, number.at, number.other);
    case ClaimMeasure::abrupt:
      return errors.abrupt();
    case ClaimMeasure::clock_cost:
      return errors.clock_cost(number.method, number.seconds);
    case ClaimMeasure::largest_wrist_height:
      return errors.largest_wrist_height(number.method);
    case ClaimMeasure::wrist_height:
      return errors.wrist_height(number.method);
    case ClaimMeasure::interpretations:
    case ClaimMeasure::share:
    case ClaimMeasure::wand_distance:
      break;
  }
  return std::nullopt;
}

std::optional<Measurement> measure(const ClaimedNumber& number, const SweepSummary& sweep) {
  if (number.measure != ClaimMeasure::interpretations) return std::nullopt;
  return acceptable_interpretations(sweep);
}

std::optional<Measurement> measure(const ClaimedNumber& number, const ClocksSummary& clocks) {
  if (number.measure != ClaimMeasure::share) return std::nullopt;
  return share_of_units(clocks, number.key);
}

std::optional<Measurement> measure(const ClaimedNumber& number, const CalibrationRecordings& calibration) {
  if (number.measure != ClaimMeasure::wand_distance) return std::nullopt;
  if (number.other_zone) return wand_error(calibration, number.zone, *number.other_zone);
  return wand_error(calibration, number.zone, number.less_m);
}

// The numbers of every claim and erratum that such a repetition of the paper measures.
std::vector<ClaimNumber> numbers_of(const std::string& paper, const auto& source) {
  std::vector<ClaimNumber> numbers;
  const auto add = [&](const auto& row, const std::optional<ClaimBound>& bound) {
    if (row.study != paper) return;
    for (const ClaimedNumber& number : row.numbers)
      if (const auto measured = measure(number, source))
        numbers.push_back(claim_number(row.id, *measured, number.bound ? number.bound : bound));
  };
  for (const PaperClaim& claim : paper_claims()) add(claim, claim.bound);
  for (const ErratumEffect& effect : erratum_effects()) add(effect, std::nullopt);
  return numbers;
}

}  // namespace

std::span<const PaperClaim> paper_claims() { return claims_file().claims; }
std::span<const ErratumEffect> erratum_effects() { return claims_file().effects; }

std::vector<std::string> compared_with(const std::string& paper) {
  if (paper == name_of(PaperStudy::none)) return {};
  std::set<std::string> methods{ErrorMeasures::kVia};
  const auto add = [&](const auto& row) {
    for (const ClaimedNumber& number : row.numbers)
      if (row.study == paper && !number.against.empty()) methods.insert(number.against);
  };
  std::ranges::for_each(paper_claims(), add);
  std::ranges::for_each(erratum_effects(), add);
  return {methods.begin(), methods.end()};
}

std::vector<ClaimNumber> claims_of(const StudyErrors& errors) {
  std::vector<ClaimNumber> numbers = numbers_of(errors.names().paper, ErrorMeasures(errors));
  if (errors.names().left_out())
    for (ClaimNumber& number : numbers)
      number = {.claim = number.claim, .missing = "motion capture: differences from a sensor are no errors"};
  return numbers;
}
std::vector<ClaimNumber> claims_of(const SweepSummary& summary) { return numbers_of(summary.paper, summary); }
std::vector<ClaimNumber> claims_of(const ClocksSummary& summary) {
  return numbers_of(summary.paper, summary);
}
std::vector<ClaimNumber> claims_of(const std::string& paper, const CalibrationRecordings& recordings) {
  return numbers_of(paper, recordings);
}

}  // namespace trilat
