// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "reports/tables/table.h"
#include "reports/tables/tables.h"

namespace trilat {
namespace {

constexpr double kAlways = 0.975, kNever = 0.025;  // shares

std::string percent_text(const Estimate& share) {
  if (!std::isfinite(share.low)) return fmt::format("{:.0f} %", 100.0 * share.value);
  return fmt::format("{:.0f} % ({:.0f} to {:.0f})", 100.0 * share.value, 100.0 * share.low,
                     100.0 * share.high);
}

TableValue estimate_cell(int decimals, const Estimate& e) {
  return number_cell(decimals, e.value, e.low, e.high);
}
TableValue share_cell(const Estimate& e) { return percent_cell(e.value, e.low, e.high); }

std::string unit_of(const SensitivityFactor& factor) { return factor.unit.empty() ? "" : ' ' + factor.unit; }

const SensitivityFactor& factor_of(const SensitivitySummary& s, const std::string& name) {
  return *std::ranges::find(s.factors, name, &SensitivityFactor::name);
}

// Where the mean difference changes its sign; of lists and whole numbers, the values at which the claim
// mostly holds. Empty when there is nothing to say.
std::string flip_text(const SensitivitySummary& s, const ClaimByFactor& by) {
  const SensitivityFactor& factor = factor_of(s, by.factor);
  const Estimate& e = by.break_even;
  if (std::isfinite(e.value))
    return fmt::format("{} {:.3g}{} ({:.3g} to {:.3g})", by.factor, e.value, unit_of(factor), e.low, e.high);
  if (factor.values.empty()) return {};
  std::vector<std::string> holds;
  for (std::size_t b = 0; b < by.bins.size(); ++b)
    if (by.bins[b].difference_percent.value < 0.0) holds.push_back(factor.values[b]);
  if (holds.empty() || holds.size() == by.bins.size()) return {};
  return fmt::format("{}: on average only {}", by.factor, fmt::join(holds, ", "));
}

std::string flips_of(const SensitivitySummary& s, const SensitivityClaim& claim) {
  std::vector<std::string> flips;
  for (const ClaimByFactor& by : claim.factors)
    if (const std::string text = flip_text(s, by); !text.empty()) flips.push_back(text);
  return fmt::format("{}", fmt::join(flips, "; "));
}

// Of the space.
std::uint64_t campaigns_of(const SensitivitySummary& s) { return s.rows * (s.factors.size() + 2); }

// The factors that explain most of the difference, by their total index.
std::string decisive_of(const SensitivityClaim& claim) {
  constexpr std::size_t kMost = 3;
  constexpr double kWorthNaming = 0.05;
  std::vector<ClaimByFactor> factors = claim.factors;
  std::ranges::sort(
      factors, [](const ClaimByFactor& a, const ClaimByFactor& b) { return a.total.value > b.total.value; });
  std::vector<std::string> names;
  for (const ClaimByFactor& by : factors)
    if (names.size() < kMost && by.total.value > kWorthNaming)
      names.push_back(fmt::format("{} ({:.0f} %)", by.factor, 100.0 * by.total.value));
  return fmt::format("{}", fmt::join(names, ", "));
}

Table claims_table(const SensitivitySummary& s) {
  Table table;
  table.id = "claims";
  table.title = fmt::format(
      "Where each claim holds, simulated: {} campaigns of {} participants all over the space (alignment: {})",
      campaigns_of(s), s.participants, s.alignments.front());
  table.columns = {{"claim", "claim", true},
                   {"compared in", "compared"},
                   interval_column("holds in (%)", "share_percent"),
                   {"mean difference (%)", "difference_percent"},
                   {"at worst (%)", "worst_percent"},
                   interval_column("as simulated (%)", "default_percent"),
                   {"decided by", "decided_by", true},
                   {"changes at", "changes_at", true}};
  for (const SensitivityClaim& claim : s.claims)
    table.rows.push_back({TableValue::of(claim.name),
                          TableValue::of(static_cast<double>(campaigns_of(s) - claim.silent), 0),
                          share_cell(claim.share), TableValue::of(claim.difference_percent.value, 1),
                          TableValue::of(claim.worst_percent, 1), estimate_cell(1, claim.default_percent),
                          TableValue::of(decisive_of(claim)), TableValue::of(flips_of(s, claim))});
  table.notes = notes("space_claims");
  return table;
}

// The same claims under all alignments and in the parts of the space that the study names.
Table side_by_side_table(const SensitivitySummary& s) {
  Table table;
  table.id = "claims_side_by_side";
  table.title = "Each claim under every alignment, simulated";
  table.columns = {{"claim", "claim", true},
                   {"part of the space", "part", true},
                   {"alignment", "alignment", true},
                   {"compared in", "compared"},
                   interval_column("holds in (%)", "share_percent"),
                   interval_column("mean difference (%)", "difference_percent"),
                   {"at worst (%)", "worst_percent"},
                   interval_column("as simulated (%)", "default_percent")};
  for (const SensitivityClaim& claim : s.claims)
    for (const ClaimIn& in : claim.side_by_side)
      table.rows.push_back({TableValue::of(claim.name), TableValue::of(in.part.empty() ? "all" : in.part),
                            TableValue::of(in.alignment), TableValue::of(static_cast<double>(in.compared), 0),
                            share_cell(in.share), estimate_cell(1, in.difference_percent),
                            TableValue::of(in.worst_percent, 1), estimate_cell(1, in.default_percent)});
  table.notes = notes("claims_side_by_side");
  return table;
}

Table indices_table(const SensitivitySummary& s) {
  Table table;
  table.id = "indices";
  table.title = "What decides each difference, simulated: Sobol indices with 95 % intervals";
  table.columns = {{"claim", "claim", true},
                   {"factor", "factor", true},
                   interval_column("first", "first"),
                   interval_column("total", "total"),
                   interval_column("changes at", "break_even"),
                   {"unit", "unit", true}};
  for (const SensitivityClaim& claim : s.claims)
    for (const ClaimByFactor& by : claim.factors) {
      table.rows.push_back({TableValue::of(claim.name), TableValue::of(by.factor), estimate_cell(2, by.first),
                            estimate_cell(2, by.total), estimate_cell(-1, by.break_even),
                            TableValue::of(factor_of(s, by.factor).unit)});
    }
  return table;
}

Table methods_table(const SensitivitySummary& s) {
  Table table;
  table.id = "best_methods";
  table.title = "Which method errs least, simulated: share of the space";
  table.columns = {{"method", "method", true}, interval_column("best in (%)", "share_percent")};
  for (std::size_t m = 0; m < s.methods.size(); ++m)
    table.rows.push_back({TableValue::of(s.methods[m]), share_cell(s.best_share[m])});
  return table;
}

Table space_table(const SensitivitySummary& s) {
  Table table;
  table.id = "space";
  table.title = "The space that was simulated";
  table.columns = {{"factor", "factor", true}, {"setting", "setting", true}, {"values", "values", true}};
  for (const SensitivityFactor& f : s.factors)
    table.rows.push_back(
        {TableValue::of(f.name), TableValue::of(f.setting),
         TableValue::of(!f.values.empty() ? fmt::format("{}", fmt::join(f.values, ", "))
                                          : fmt::format("{:g} to {:g}{}{}", f.low, f.high, unit_of(f),
                                                        f.logarithmic ? ", logarithmic"
                                                        : f.whole     ? ", whole"
                                                                      : ""))});
  return table;
}

// Under which alignment that is, and what it is under the others.
std::string alignments_text(const SensitivityClaim& claim) {
  std::string text;
  for (const ClaimIn& in : claim.side_by_side)
    if (in.part.empty())
      text += text.empty() ? fmt::format(", aligned `{}`", in.alignment)
                           : fmt::format("; `{}` {}", in.alignment, percent_text(in.share));
  return text;
}

}  // namespace

std::vector<Table> sensitivity_tables(const SensitivitySummary& s) {
  return {claims_table(s), side_by_side_table(s), methods_table(s), indices_table(s), space_table(s)};
}

std::vector<std::string> sensitivity_sentences(const SensitivitySummary& s) {
  std::vector<std::string> sentences;
  for (const SensitivityClaim& claim : s.claims) {
    const bool always = claim.share.low >= kAlways, never = claim.share.high <= kNever;
    std::string text =
        fmt::format("**{}** holds in {} of {} simulated campaigns all over the space of settings{}",
                    claim.name, percent_text(claim.share), campaigns_of(s), alignments_text(claim));
    if (const std::string flips = flips_of(s, claim); !always && !never && !flips.empty())
      text += fmt::format("; it changes at {}", flips);
    if (claim.silent > 0)
      text += fmt::format("; campaigns without a sample that both methods answer do not count: {} of {}",
                          claim.silent, campaigns_of(s));
    sentences.push_back(text + '.');
  }
  return sentences;
}

}  // namespace trilat
