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
  using R = SensitivityClaim;
  Table table = table_of<R>(
      "claims",
      fmt::format("Where each claim holds, simulated: {} campaigns of {} participants all over the space "
                  "(alignment: {})",
                  campaigns_of(s), s.participants, s.alignments.front()),
      s.claims,
      {{"claim", "claim", as_text(&R::name)},
       {"compared in", "compared", as_count([&](const R& r) { return campaigns_of(s) - r.silent; })},
       {"holds in (%)", "share_percent", as_number(1, 100.0, &R::share)},
       {"mean difference (%)", "difference_percent",
        of(&R::difference_percent, as_number(1, &Estimate::value))},
       {"at worst (%)", "worst_percent", as_number(1, &R::worst_percent)},
       {"as simulated (%)", "default_percent", as_number(1, 1.0, &R::default_percent)},
       {"decided by", "decided_by", as_text(decisive_of)},
       {"changes at", "changes_at", as_text([&](const R& r) { return flips_of(s, r); })}});
  add_notes(table, "space_claims");
  return table;
}

// The same claims under all alignments and in the parts of the space that the study names.
Table side_by_side_table(const SensitivitySummary& s) {
  struct Row {
    std::string claim;
    ClaimIn in;
  };
  std::vector<Row> rows;
  for (const SensitivityClaim& claim : s.claims)
    for (const ClaimIn& in : claim.side_by_side) rows.push_back({claim.name, in});
  using C = ClaimIn;
  Table table = table_of<Row>(
      "claims_side_by_side", "Each claim under every alignment, simulated", rows,
      {{"claim", "claim", as_text(&Row::claim)},
       {"part of the space", "part",
        of(&Row::in, as_text([](const C& c) { return c.part.empty() ? "all" : c.part; }))},
       {"alignment", "alignment", of(&Row::in, as_text(&C::alignment))},
       {"compared in", "compared", of(&Row::in, as_count(&C::compared))},
       {"holds in (%)", "share_percent", of(&Row::in, as_number(1, 100.0, &C::share))},
       {"mean difference (%)", "difference_percent", of(&Row::in, as_number(1, 1.0, &C::difference_percent))},
       {"at worst (%)", "worst_percent", of(&Row::in, as_number(1, &C::worst_percent))},
       {"as simulated (%)", "default_percent", of(&Row::in, as_number(1, 1.0, &C::default_percent))}});
  add_notes(table, "claims_side_by_side");
  return table;
}

Table indices_table(const SensitivitySummary& s) {
  struct Row {
    std::string claim;
    ClaimByFactor by;
  };
  std::vector<Row> rows;
  for (const SensitivityClaim& claim : s.claims)
    for (const ClaimByFactor& by : claim.factors) rows.push_back({claim.name, by});
  using B = ClaimByFactor;
  return table_of<Row>(
      "indices", "What decides each difference, simulated: Sobol indices with 95 % intervals", rows,
      {{"claim", "claim", as_text(&Row::claim)},
       {"factor", "factor", of(&Row::by, as_text(&B::factor))},
       {"first", "first", of(&Row::by, as_number(2, 1.0, &B::first))},
       {"total", "total", of(&Row::by, as_number(2, 1.0, &B::total))},
       {"changes at", "break_even", of(&Row::by, as_number(-1, 1.0, &B::break_even))},
       {"unit", "unit", as_text([&](const Row& r) { return factor_of(s, r.by.factor).unit; })}});
}

Table methods_table(const SensitivitySummary& s) {
  struct Row {
    std::string method;
    Estimate share;
  };
  std::vector<Row> rows;
  for (std::size_t m = 0; m < s.methods.size(); ++m) rows.push_back({s.methods[m], s.best_share[m]});
  return table_of<Row>("best_methods", "Which method errs least, simulated: share of the space", rows,
                       {{"method", "method", as_text(&Row::method)},
                        {"best in (%)", "share_percent", as_number(1, 100.0, &Row::share)}});
}

std::string values_text(const SensitivityFactor& f) {
  if (!f.values.empty()) return fmt::format("{}", fmt::join(f.values, ", "));
  return fmt::format("{:g} to {:g}{}{}", f.low, f.high, unit_of(f),
                     f.logarithmic ? ", logarithmic"
                     : f.whole     ? ", whole"
                                   : "");
}

Table space_table(const SensitivitySummary& s) {
  using R = SensitivityFactor;
  return table_of<R>("space", "The space that was simulated", s.factors,
                     {{"factor", "factor", as_text(&R::name)},
                      {"setting", "setting", as_text(&R::setting)},
                      {"values", "values", as_text(values_text)}});
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
