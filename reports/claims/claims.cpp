// SPDX-License-Identifier: MIT
#include "reports/claims/claims.h"

#include <cmath>

#include <fmt/format.h>

#include "datasets/paper/printed_tables.h"

namespace trilat {
namespace {

std::string estimate_text(const ClaimEstimate& e, const std::string& unit) {
  if (!std::isfinite(e.value)) return "no answer";
  const int decimals = std::abs(e.value) < 10.0 ? 2 : std::abs(e.value) < 100.0 ? 1 : 0;
  const std::string value = fmt::format("{:.{}f} {}", e.value, decimals, unit);
  if (!std::isfinite(e.low)) return value;
  const std::string level = e.level_percent == 95.0 ? "" : fmt::format(" at {:.4g} %", e.level_percent);
  return fmt::format("{} ({:.{}f} to {:.{}f}{})", value, e.low, decimals, e.high, decimals, level);
}

std::string rule_text(const JudgedClaim& claim) {
  if (claim.parts.empty()) return claim.reason;
  std::string bounds;
  for (const ClaimPart& part : claim.parts)
    if (bounds.find(part.bound) == std::string::npos) bounds += (bounds.empty() ? "" : ", ") + part.bound;
  return fmt::format("{}: {}; over {}", bounds, claim.reason, claim.clusters);
}

}  // namespace

std::string parts_text(const std::vector<ClaimPart>& parts, bool complete) {
  std::string text;
  for (const ClaimPart& part : parts) {
    if (complete && !part.complete) continue;
    text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", part.what,
                        estimate_text(complete ? *part.complete : part.estimate, part.unit));
  }
  return text.empty() ? "–" : text;
}

Table claims_table(const PaperFindings& findings) {
  Table table;
  table.id = "claims";
  table.title = fmt::format("The paper's claims and what becomes of them{}",
                            findings.evidence.any_simulated() ? ", with simulated sensors" : "");
  table.columns = {{"claim", "claim", true},
                   {"verdict", "verdict", true},
                   {"paper", "paper", true},
                   {"ours, with interval", "ours", true},
                   {"where any answers", "complete", true},
                   {"margin and reason", "rule", true},
                   {"p", "p"},
                   {"corrected", "corrected", true},
                   {"where", "where", true}};
  for (const JudgedClaim& claim : findings.claims)
    table.rows.push_back({TableValue::of(claim.claim), TableValue::of(claim.verdict),
                          TableValue::of(claim.printed), TableValue::of(parts_text(claim.parts, false)),
                          TableValue::of(parts_text(claim.parts, true)), TableValue::of(rule_text(claim)),
                          TableValue::of(claim.chance, 4), TableValue::of(claim.confirmatory ? "Holm" : "no"),
                          TableValue::of(claim.where)});
  table.notes = {
      "Paper: " + printed_errata().source +
          "; claims in our words, one row each in datasets/paper/claims.json.",
      "A claim holds when the interval of its number lies wholly on its side of the margin. It does not hold "
      "when the "
      "interval lies wholly on the other side, and is undecided otherwise. Of several numbers all have to "
      "hold. The "
      "interval is of 95 %, or of the level that stands behind it: claims marked Holm are decided together, "
      "so that at "
      "most one repetition in twenty has a false verdict among them, and each needs a higher level. p is "
      "twice the "
      "probability of a number as far from the margin if the truth were on the other side (Student's t "
      "between "
      "clusters), after Holm for the claims marked so.",
      "Percent: of the error of the method, joints or zone that stands second, on the samples that both "
      "answer. "
      "Where any answers: on the samples that any of the two answers; where one has no answer, the other's "
      "error counts "
      "for both.",
      "\"But … of the size\": the whole interval lies outside of 0.8 to 1.25 times what the paper prints."};
  if (findings.evidence.any_simulated())
    table.notes.push_back(
        "Our numbers are simulated: a verdict says what follows from the errors that sensors and tracker are "
        "declared "
        "to have (by default the tracker's are measured on real people), not what the paper's recordings "
        "showed.");
  return table;
}

}  // namespace trilat
