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
  using R = JudgedClaim;
  Table table = table_of<R>(
      "claims",
      fmt::format("The paper's claims and what becomes of them{}",
                  findings.evidence.any_simulated() ? ", with simulated sensors" : ""),
      findings.claims,
      {{"claim", "claim", as_text(&R::claim)},
       {"verdict", "verdict", as_text(&R::verdict)},
       {"paper", "paper", as_text(&R::printed)},
       {"ours, with interval", "ours", as_text([](const R& r) { return parts_text(r.parts, false); })},
       {"where any answers", "complete", as_text([](const R& r) { return parts_text(r.parts, true); })},
       {"margin and reason", "rule", as_text(rule_text)},
       {"p", "p", as_number(4, &R::chance)},
       {"corrected", "corrected", as_text([](const R& r) { return r.confirmatory ? "Holm" : "no"; })},
       {"where", "where", as_text(&R::where)}});
  add_notes(table, "paper_claims", {{"source", printed_errata().source}});
  if (findings.evidence.any_simulated()) add_notes(table, "simulated_claims");
  return table;
}

}  // namespace trilat
