// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "reports/sweep_tables.h"

namespace trilat {
namespace {

// A compromise worth the name: the smallest threshold costs this many times the steps of the largest.
constexpr double kCostly = 5.0;
constexpr double kFewAnswers = 0.9;  // share of the trials

Table ranking_table(const SweepSummary& s, const SweepRanking& ranking, bool errors) {
  Table table;
  table.id = errors ? "table1-search-errors" : "table1-search-times";
  table.title = fmt::format(
      "Which reading of the paper gives the printed {} of Table I: the best {} of {} ranked, {} tried, "
      "simulated "
      "({} trials a cell, seed {})",
      errors ? "errors" : "times", ranking.best.size(), ranking.ranked, s.search->tried, s.trials, s.seed);
  table.columns = {{"rank", "rank", false},
                   {"reading", "reading", true},
                   {"reported", "reported", true},
                   {"typical factor", "typical_factor", false},
                   {"worst factor", "worst_factor", false}};
  if (!errors) table.columns.push_back({"us a step", "us_per_iteration", false});
  for (std::size_t i = 0; i < ranking.best.size(); ++i) {
    const SweepFit& fit = ranking.best[i];
    table.rows.push_back({TableValue::of(static_cast<double>(i + 1), 0),
                          TableValue::of(s.interpretations[fit.interpretation].id),
                          TableValue::of(fit.reported), TableValue::of(std::exp(fit.rms_log_ratio), 2),
                          TableValue::of(fit.worst_factor, 2)});
    if (!errors) table.rows.back().push_back(TableValue::of(fit.us_per_iteration, 3));
  }
  table.notes = {
      fmt::format("The typical factor between ours and the printed numbers is exp of the root mean square of "
                  "their log ratios "
                  "over the twelve cells. Over all readings: best {:.2f}, median {:.2f}, worst {:.2f}.",
                  std::exp(ranking.best_rms), std::exp(ranking.median_rms), std::exp(ranking.worst_rms))};
  table.notes.push_back(errors ? "A search over readings fits what it can: it shows which one explains the "
                                 "table, not that the paper "
                                 "used it. Nothing else here was tuned to it."
                               : "Printed times are compared with our numbers of iterations times one scale "
                                 "that fits best, because "
                                 "processors differ.");
  return table;
}

Table compromise_table(const SweepSummary& s) {
  Table table;
  table.id = "table1-search-compromise";
  table.title = fmt::format(
      "What the smallest threshold (C = {:g}) costs and brings against the largest (C = {:g}), with either "
      "gradient, "
      "simulated ({} trials a cell)",
      *std::min_element(s.thresholds.begin(), s.thresholds.end()),
      *std::max_element(s.thresholds.begin(), s.thresholds.end()), s.trials);
  table.columns = {{"best for", "best_for", true},
                   {"reading", "reading", true},
                   {"error range (cm)", "range_cm", true},
                   {"steps x, printed", "printed_iterations_factor", false},
                   {"steps x, corrected", "corrected_iterations_factor", false},
                   {"error x, printed", "printed_error_factor", false},
                   {"error x, corrected", "corrected_error_factor", false},
                   {"answered, printed (%)", "printed_coverage_percent", false},
                   {"answered, corrected (%)", "corrected_coverage_percent", false}};
  table.notes = {
      "Answered: the least share of trials with a usable estimate in any cell of the reading. Where it is "
      "low, the "
      "factors are those of the easy trials: undamped Gauss-Newton diverges or cycles on nearly flat rigs."};
  for (const SweepCompromise& c : s.search->compromises)
    for (std::size_t r = 0; r < s.ranges.size(); ++r)
      table.rows.push_back(
          {TableValue::of(c.best_for), TableValue::of(s.interpretations[c.printed].id),
           TableValue::of(fmt::format("{:g}-{:g}", s.ranges[r].low_m * kCentimetresPerMetre,
                                      s.ranges[r].high_m * kCentimetresPerMetre)),
           TableValue::of(c.printed_iterations_factor[r], 1),
           TableValue::of(c.corrected_iterations_factor[r], 1), TableValue::of(c.printed_error_factor[r], 2),
           TableValue::of(c.corrected_error_factor[r], 2), TableValue::of(100.0 * c.printed_coverage, 1),
           TableValue::of(100.0 * c.corrected_coverage, 1)});
  return table;
}

std::string span_text(const std::vector<double>& factors) {
  const auto [low, high] = std::minmax_element(factors.begin(), factors.end());
  const auto text = [](double factor) {
    return factor < 10.0 ? fmt::format("{:.2g}", factor) : fmt::format("{:.0f}", factor);
  };
  return text(*low) + " to " + text(*high);
}

std::string compromise_sentence(const SweepCompromise& c) {
  const auto most = [](const std::vector<double>& f) { return *std::max_element(f.begin(), f.end()); };
  const bool printed_pays = most(c.printed_iterations_factor) > kCostly;
  const bool corrected_pays = most(c.corrected_iterations_factor) > kCostly;
  const std::string verdict = !printed_pays    ? "there is no compromise even with the printed gradient"
                              : corrected_pays ? "the compromise survives the corrected gradient"
                                               : "the compromise does not survive the corrected gradient";
  std::string text = fmt::format(
      "In the reading that fits the printed {} best, the smallest threshold takes {} times the steps of the "
      "largest "
      "with the printed gradient and {} times with the corrected one, for {} and {} times the error: {}.",
      c.best_for, span_text(c.printed_iterations_factor), span_text(c.corrected_iterations_factor),
      span_text(c.printed_error_factor), span_text(c.corrected_error_factor), verdict);
  if (c.corrected_coverage < kFewAnswers)
    text += fmt::format(
        " (On this rig undamped corrected Gauss-Newton answers as few as {:.0f} % of the trials, so these "
        "factors are "
        "those of the easy ones.)",
        100.0 * c.corrected_coverage);
  return text;
}

}  // namespace

std::vector<Table> search_tables(const SweepSummary& s) {
  if (!s.search) return {};
  std::vector<Table> tables{ranking_table(s, s.search->errors, true),
                            ranking_table(s, s.search->times, false)};
  if (!s.search->compromises.empty()) tables.push_back(compromise_table(s));
  return tables;
}

std::vector<std::string> search_sentences(const SweepSummary& s) {
  std::vector<std::string> sentences;
  if (!s.search) return sentences;
  for (const auto& [what, ranking] :
       {std::pair{"errors", &s.search->errors}, std::pair{"times", &s.search->times}}) {
    if (ranking->best.empty()) continue;
    const SweepFit& fit = ranking->best.front();
    sentences.push_back(
        fmt::format("Of {} readings tried, {} fits the printed {} best: typically within a factor of {:.2f}, "
                    "at worst {:.2f} "
                    "(the median reading: {:.2f}).",
                    s.search->tried, s.interpretations[fit.interpretation].id, what,
                    std::exp(fit.rms_log_ratio), fit.worst_factor, std::exp(ranking->median_rms)));
  }
  for (const SweepCompromise& c : s.search->compromises) sentences.push_back(compromise_sentence(c));
  return sentences;
}

}  // namespace trilat
