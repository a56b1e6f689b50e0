// SPDX-License-Identifier: MIT
#include "reports/claims.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "datasets/paper/printed_tables.h"
#include "reports/claim_evidence.h"

namespace trilat {
namespace {

bool has_condition(const ResultsSummary& s, const std::string& name) {
  return std::find(s.conditions.begin(), s.conditions.end(), name) != s.conditions.end();
}
bool has_method(const ResultsSummary& s, const std::string& name) {
  return std::find(s.methods.begin(), s.methods.end(), name) != s.methods.end();
}

bool is_one_of(const std::string& id, std::initializer_list<const char*> ids) {
  return std::find(ids.begin(), ids.end(), id) != ids.end();
}

ClaimVerdict verdict_on(const std::string& id, const ClaimEvidence& evidence) {
  if (is_one_of(id, {"occlusion_arms", "occlusion_legs", "legs_worse"}))
    return verdict_on_occlusion(id, evidence);
  if (is_one_of(id, {"threshold", "wand_accuracy", "wand_near", "clock_good_enough", "real_time",
                     "clock_error", "cycles", "averages"}))
    return verdict_on_parts(id, evidence);
  return verdict_on_methods(id, evidence);
}

}  // namespace

void ClaimEvidence::add(const ResultsSummary& summary) {
  if (has_method(summary, "nonlinear, 4 sensors") && has_method(summary, "nonlinear, 8 sensors")) {
    sensor_counts.push_back(summary);
    return;
  }
  if (!walking && has_condition(summary, "walking") && has_method(summary, "nonlinear")) walking = summary;
  if (!occluded && (has_condition(summary, occluded_condition("arm_swing")) ||
                    has_condition(summary, occluded_condition("leg_crossing"))))
    occluded = summary;
}

std::string cell_text(const SummaryCell* cell) {
  if (!cell || !std::isfinite(cell->mae_m)) return "no answer";
  std::string text = fmt::format("{:.2f} cm", cell->mae_m * kCentimetresPerMetre);
  if (std::isfinite(cell->mae_low_m))
    text += fmt::format(" ({:.2f} to {:.2f})", cell->mae_low_m * kCentimetresPerMetre,
                        cell->mae_high_m * kCentimetresPerMetre);
  return text;
}

std::string worse_text(const DifferenceCell* d) {
  if (!d || !std::isfinite(d->difference_m)) return "not compared";
  const bool worse = d->difference_m >= 0.0;
  const double sign = worse ? kCentimetresPerMetre : -kCentimetresPerMetre;
  std::string text = fmt::format("{} by {:.2f} cm", worse ? "worse" : "better", sign * d->difference_m);
  if (std::isfinite(d->low_m))
    text += fmt::format(" ({:.2f} to {:.2f})", sign * (worse ? d->low_m : d->high_m),
                        sign * (worse ? d->high_m : d->low_m));
  return text + fmt::format(", {:.1f} %", std::abs(d->percent_of_reference));
}

std::string paired_text(const DifferenceCell* d) {
  if (!d || !std::isfinite(d->difference_m) || d->difference_m == 0.0) return "not compared";
  const double reference_m = 100.0 * d->difference_m / d->percent_of_reference;
  return fmt::format("{:.2f} against {:.2f} cm", (reference_m + d->difference_m) * kCentimetresPerMetre,
                     reference_m * kCentimetresPerMetre);
}

const DifferenceCell* find_difference(const ResultsSummary& s, const std::string& method,
                                      const std::string& condition, const std::string& group,
                                      const std::string& alignment) {
  for (const DifferenceCell& d : s.differences)
    if (d.method == method && d.condition == condition && d.group == group && d.alignment == alignment)
      return &d;
  return nullptr;
}

ClaimVerdict not_run(const std::string& study) {
  return {"–", kCannotTest, "the results of " + study + " are not among those of this report"};
}

bool any_simulated(const ClaimEvidence& e) {
  return (e.walking && e.walking->simulated) || (e.occluded && e.occluded->simulated) ||
         std::any_of(e.sensor_counts.begin(), e.sensor_counts.end(),
                     [](const ResultsSummary& s) { return s.simulated; }) ||
         e.sweep || e.calibration || e.recording;
}

Table claims_table(const ClaimEvidence& evidence) {
  const PrintedClaims printed = printed_claims();
  Table table;
  table.id = "claims";
  table.title = fmt::format("The paper's claims and what becomes of them{}",
                            any_simulated(evidence) ? ", with simulated sensors" : "");
  table.columns = {{"claim", "claim", true},     {"where", "where", true},     {"paper", "paper", true},
                   {"ours, 95 %", "ours", true}, {"verdict", "verdict", true}, {"why", "reason", true}};
  for (const PrintedClaims::Claim& claim : printed.claims) {
    const ClaimVerdict verdict = verdict_on(claim.id, evidence);
    table.rows.push_back({TableValue::of(claim.claim), TableValue::of(claim.where),
                          TableValue::of(claim.printed), TableValue::of(verdict.ours),
                          TableValue::of(verdict.verdict), TableValue::of(verdict.reason)});
  }
  table.notes = {
      "Paper: " + printed.source + "; claims in our words.",
      "A claim holds when the 95 % interval of the paired difference is on its side of zero, does not hold "
      "when it is on the other side, and is undecided when it contains zero. Differences of two methods are "
      "of the "
      "samples that both answer, in percent of nonlinear's error; an error that stands by itself is over "
      "what its "
      "method answers."};
  if (any_simulated(evidence))
    table.notes.push_back(
        "Our numbers are simulated: a verdict says what follows from the declared errors of sensors and "
        "tracker, not what the paper's recordings showed.");
  return table;
}

}  // namespace trilat
