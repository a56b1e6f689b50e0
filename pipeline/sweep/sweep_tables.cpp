// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_tables.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "datasets/base/median.h"
#include "datasets/base/units.h"
#include "pipeline/sweep/table1.h"

namespace trilat {
namespace {

constexpr double kFewAnswers = 0.9;  // share of the trials; below it the factors are those of the easy ones

// Largest relative half interval of the mean errors of a reading's cells.
double worst_half_interval(const SweepSummary& s, std::size_t reading) {
  double worst = 0.0;
  for (const SweepCell& c : s.cells)
    if (c.interpretation == reading) worst = std::max(worst, c.mae_half_interval_m() / c.mae_m);
  return worst;
}

Table ranking_table(const SweepSummary& s, const SweepRanking& ranking, bool errors) {
  Table table;
  table.id = errors ? "search-errors" : "search-times";
  table.title = fmt::format(
      "Which reading of the paper gives the printed {} of Table I: the best {} of {}, simulated ({} tried; "
      "{} answered nine trials in ten in every cell and are ranked{}; {} trials a cell, seed {})",
      errors ? "errors" : "times", ranking.best.size(), ranking.ranked, s.search->tried,
      s.search->times.ranked, errors ? ", each by two metrics" : "", s.trials, s.seed);
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
  table.notes = {fmt::format(
      "The typical factor between ours and the printed numbers is exp of the root mean square of their log "
      "ratios over the twelve cells. Over all readings: best {:.2f}, median {:.2f}, worst {:.2f}.",
      std::exp(ranking.best_rms), std::exp(ranking.median_rms), std::exp(ranking.worst_rms))};
  if (!errors)
    table.notes.push_back(
        "Printed times are compared with our numbers of iterations times one scale that fits best, because "
        "processors differ.");
  else if (!ranking.best.empty())
    table.notes.push_back(
        fmt::format("The mean error of a cell is known to within {:.1f} % (95 %, the worst cell of the first "
                    "reading): neighbours in this list are ties. A search fits what it can: it shows which "
                    "reading explains the table, not that the paper used it.",
                    100.0 * worst_half_interval(s, ranking.best.front().interpretation)));
  return table;
}

Table compromise_table(const SweepSummary& s) {
  struct Row {
    const SweepCompromise* c;
    std::size_t range;
  };
  std::vector<Row> rows;
  for (const SweepCompromise& c : s.search->compromises)
    for (std::size_t r = 0; r < s.ranges.size(); ++r) rows.push_back({&c, r});
  using Factors = std::vector<double> SweepCompromise::*;
  const auto factor = [](int decimals, Factors factors) {
    return as_number(decimals, [=](const Row& r) { return (r.c->*factors)[r.range]; });
  };
  Table table = table_of<Row>(
      "search-compromise",
      fmt::format("What the smallest threshold (C = {:g}) costs and brings against the largest (C = {:g}), "
                  "with either gradient, simulated ({} trials a cell)",
                  *std::ranges::min_element(s.thresholds), *std::ranges::max_element(s.thresholds), s.trials),
      rows,
      {{"best for", "best_for", as_text([](const Row& r) { return r.c->best_for; })},
       {"printed reading", "reading",
        as_text([&](const Row& r) { return s.interpretations[r.c->printed].id; })},
       {"corrected's damping", "corrected_damping",
        as_text([&](const Row& r) { return s.interpretations[r.c->corrected].damping; })},
       {"error range (cm)", "range_cm", as_text([&](const Row& r) {
          return fmt::format("{:g}-{:g}", s.ranges[r.range].low_m * kCentimetresPerMetre,
                             s.ranges[r.range].high_m * kCentimetresPerMetre);
        })},
       {"steps x, printed", "printed_iterations_factor",
        factor(1, &SweepCompromise::printed_iterations_factor)},
       {"steps x, corrected", "corrected_iterations_factor",
        factor(1, &SweepCompromise::corrected_iterations_factor)},
       {"error x, printed", "printed_error_factor", factor(2, &SweepCompromise::printed_error_factor)},
       {"error x, corrected", "corrected_error_factor", factor(2, &SweepCompromise::corrected_error_factor)},
       {"answered, printed (%)", "printed_coverage_percent",
        in_percent([](const Row& r) { return r.c->printed_coverage; })},
       {"answered, corrected (%)", "corrected_coverage_percent",
        in_percent([](const Row& r) { return r.c->corrected_coverage; })}});
  add_notes(table, "search_compromise");
  return table;
}

std::string span_text(const std::vector<double>& factors) {
  const auto [low, high] = std::minmax_element(factors.begin(), factors.end());
  const auto text = [](double factor) {
    return factor < 10.0 ? fmt::format("{:.2f}", factor) : fmt::format("{:.0f}", factor);
  };
  return text(*low) + " to " + text(*high);
}

bool all_finite(const std::vector<double>& factors) {
  return std::ranges::all_of(factors, [](double f) { return std::isfinite(f); });
}

// Whether accuracy is bought with time: with the printed gradient, and still with the corrected one.
std::string verdict_on(const SweepSummary& s, const SweepCompromise& c) {
  if (!(std::min(c.printed_coverage, c.corrected_coverage) >= kFewAnswers))
    return fmt::format("no verdict, because only {:.0f} % of the trials are answered",
                       100.0 * std::min(c.printed_coverage, c.corrected_coverage));
  if (!is_compromise(s, c.printed)) return "there is no compromise even with the printed gradient";
  return is_compromise(s, c.corrected) ? "the compromise survives the corrected gradient"
                                       : "the compromise does not survive the corrected gradient";
}

std::string compromise_sentence(const SweepSummary& s, const SweepCompromise& c) {
  for (const auto* factors : {&c.printed_iterations_factor, &c.corrected_iterations_factor,
                              &c.printed_error_factor, &c.corrected_error_factor})
    if (factors->empty() || !all_finite(*factors)) return "";
  return fmt::format(
      "In the reading that fits the printed {} best, the smallest threshold takes {} times the steps of the "
      "largest with the printed gradient and {} times with the corrected one (damping {}), for {} and {} "
      "times the error: {}.",
      c.best_for, span_text(c.printed_iterations_factor), span_text(c.corrected_iterations_factor),
      s.interpretations[c.corrected].damping, span_text(c.printed_error_factor),
      span_text(c.corrected_error_factor), verdict_on(s, c));
}

// The readings that fit the printed errors best, those that fit the printed times, and what the smallest
// threshold costs with either gradient. Empty without a search.
std::vector<Table> search_tables(const SweepSummary& s) {
  if (!s.search) return {};
  std::vector<Table> tables{ranking_table(s, s.search->errors, true),
                            ranking_table(s, s.search->times, false)};
  if (!s.search->compromises.empty()) tables.push_back(compromise_table(s));
  return tables;
}

// A sentence or two a person can take away from the search; empty without one.
std::vector<std::string> search_sentences(const SweepSummary& s) {
  std::vector<std::string> sentences;
  if (!s.search) return sentences;
  for (const auto& [what, ranking] :
       {std::pair{"errors", &s.search->errors}, std::pair{"times", &s.search->times}}) {
    if (ranking->best.empty()) continue;
    const SweepFit& fit = ranking->best.front();
    sentences.push_back(
        fmt::format("Of {} readings tried, {} fits the printed {} best: typically within a factor of {:.2f}, "
                    "at worst {:.2f} (the median reading: {:.2f}).",
                    s.search->tried, s.interpretations[fit.interpretation].id, what,
                    std::exp(fit.rms_log_ratio), fit.worst_factor, std::exp(ranking->median_rms)));
  }
  for (const SweepCompromise& c : s.search->compromises)
    if (const std::string sentence = compromise_sentence(s, c); !sentence.empty())
      sentences.push_back(sentence);
  return sentences;
}

}  // namespace

std::vector<std::size_t> readings_in_full(const SweepSummary& s) {
  constexpr std::size_t kMostReadingsInFull = 12;
  std::vector<std::size_t> all;
  std::set<std::size_t> leaders;
  for (std::size_t i = 0; i < s.interpretations.size(); ++i) all.push_back(i);
  if (all.size() <= kMostReadingsInFull || !s.search) return all;
  for (const SweepRanking* ranking : {&s.search->errors, &s.search->times})
    if (!ranking->best.empty()) leaders.insert(ranking->best.front().interpretation);
  for (const SweepCompromise& c : s.search->compromises) leaders.insert({c.printed, c.corrected});
  return {leaders.begin(), leaders.end()};
}

double solve_us(const SweepSummary& s, const SweepTimings& timings, const SweepCell& cell) {
  return timings.solve_us.at(static_cast<std::size_t>(&cell - s.cells.data()));
}

namespace {

constexpr std::size_t kMostCells = 200;  // in a table that is shown

// Every number of every cell, with each of its settings in a column.
Table sweep_table(const SweepSummary& s, const SweepTimings& timings) {
  using R = SweepCell;
  const auto reading = [&](std::string SweepInterpretation::*member) {
    return as_text([&s, member](const R& r) { return s.interpretations[r.interpretation].*member; });
  };
  const auto bound_m = [](double halves) {
    return [=](const R& r) { return r.mae_m + halves * r.mae_half_interval_m(); };
  };
  Table table = table_of<R>(
      "sweep", fmt::format("Every cell of the sweep, simulated; {} trials a cell, seed {}", s.trials, s.seed),
      s.cells,
      {{"rig", "rig", reading(&SweepInterpretation::rig)},
       {"joint", "joint", reading(&SweepInterpretation::joint)},
       {"errors", "error_model", reading(&SweepInterpretation::error_model)},
       {"C in", "threshold_unit", reading(&SweepInterpretation::threshold_unit)},
       {"gradient", "gradient", reading(&SweepInterpretation::gradient)},
       {"curvature", "curvature", reading(&SweepInterpretation::curvature)},
       {"stop", "stop", reading(&SweepInterpretation::stop)},
       {"damping", "damping", reading(&SweepInterpretation::damping)},
       {"start", "start", reading(&SweepInterpretation::start)},
       {"errors from (cm)", "range_low_cm",
        as_number(-1, kCentimetresPerMetre, [&](const R& r) { return s.ranges[r.range].low_m; })},
       {"to (cm)", "range_high_cm",
        as_number(-1, kCentimetresPerMetre, [&](const R& r) { return s.ranges[r.range].high_m; })},
       {"C", "threshold", as_number(-1, [&](const R& r) { return s.thresholds[r.threshold]; })},
       {"asked", "asked", as_count(&R::asked)},
       {"n", "n", as_count(&R::answered)},
       {"answered (%)", "coverage_percent",
        in_percent([](const R& r) { return share_of(r.answered, r.asked); })},
       {"mean error (cm)", "mae_cm", in_cm(&R::mae_m, bound_m(-1.0), bound_m(1.0))},
       {"axis mean (cm)", "axis_mean_mae_cm", in_cm(&R::axis_mean_mae_m)},
       {"RMSE (cm)", "rmse_cm", in_cm(&R::rmse_m)},
       {"p95 (cm)", "p95_cm", in_cm(&R::p95_m)},
       {"max (cm)", "max_cm", in_cm(&R::max_m)},
       {"start (cm)", "start_mae_cm", in_cm(&R::start_mae_m)},
       {"steps", "iterations", as_number(2, &R::mean_iterations)},
       {"p50", "iterations_p50", as_number(0, &R::p50_iterations)},
       {"p99", "iterations_p99", as_number(0, &R::p99_iterations)},
       {"max", "iterations_max", as_number(0, &R::max_iterations)},
       {timings.problems > 0 ? "a solve" : "a trial", "time_us",
        as_number(3, [&](const R& r) { return solve_us(s, timings, r); })},
       {"statuses", "statuses", as_text([](const R& r) { return statuses_text(r.statuses, r.asked); })}});
  add_notes(table, "sweep");
  return table;
}

// E7: what the printed gradient costs.
std::string steps_effect(const SweepSummary& s) {
  if (!s.search || s.search->compromises.empty()) return {};
  const SweepCompromise& c = s.search->compromises.front();
  const auto most = [](const std::vector<double>& factors) { return *std::ranges::max_element(factors); };
  return fmt::format(
      "from C = 1 to 1e-6 a solve takes up to {:.3g} times the steps as printed, {:.2g} times corrected",
      most(c.printed_iterations_factor), most(c.corrected_iterations_factor));
}

// How exactly 5000 trials give a mean, from the spread of ours: the median over readings and cells.
std::string mean_spread_effect(const SweepSummary& s) {
  constexpr double kPapersSets = 5000.0;
  std::vector<double> shares;
  for (const SweepCell& cell : s.cells) {
    const double share =
        cell.mae_standard_error_m * std::sqrt(static_cast<double>(cell.answered) / kPapersSets) / cell.mae_m;
    if (std::isfinite(share)) shares.push_back(share);
  }
  if (shares.empty()) return {};
  return fmt::format(
      "the mean of 5000 of our trials has a standard error of {:.1f} %, the median over readings and cells",
      100.0 * upper_median(shares));
}

// From the largest threshold to the smallest with one gradient, over all readings and ranges of errors.
std::string threshold_text(const SweepSummary& s, std::size_t large, std::size_t small,
                           const std::string& gradient) {
  std::vector<double> errors, steps;
  double answered = 1.0;
  for (std::size_t i = 0; i < s.interpretations.size(); ++i)
    for (std::size_t r = 0; s.interpretations[i].gradient == gradient && r < s.ranges.size(); ++r) {
      const SweepCell &before = s.cell(i, large, r), &after = s.cell(i, small, r);
      answered = std::min(
          {answered, share_of(before.answered, before.asked), share_of(after.answered, after.asked)});
      errors.push_back(after.mae_m / before.mae_m);
      steps.push_back(after.mean_iterations / before.mean_iterations);
    }
  if (!all_finite(errors) || !all_finite(steps))
    return fmt::format("some cells answer nothing with the {} gradient", gradient);
  return fmt::format(
      "{} times the steps with the {} gradient, for {} times the error ({:.0f} % answered at least)",
      span_text(steps), gradient, span_text(errors), 100.0 * answered);
}

std::string threshold_sentence(const SweepSummary& s) {
  const auto [smallest, largest] = std::ranges::minmax_element(s.thresholds);
  if (*smallest == *largest)
    return fmt::format("One threshold, C = {:g}: there is nothing to compare.", *smallest);
  std::set<std::string> gradients;
  for (const SweepInterpretation& reading : s.interpretations) gradients.insert(reading.gradient);
  std::string text;
  for (const std::string& gradient : gradients)
    text += (text.empty() ? "" : "; ") +
            threshold_text(s, static_cast<std::size_t>(largest - s.thresholds.begin()),
                           static_cast<std::size_t>(smallest - s.thresholds.begin()), gradient);
  return fmt::format(
      "From C = {:g} to C = {:g}, the least and the most over readings and ranges of errors: {}.", *largest,
      *smallest, text);
}

}  // namespace

StoredTables sweep_tables(const SweepSummary& s, const SweepTimings& timings) {
  StoredTables shown;
  shown.title = s.study;
  shown.asked = "What does the stopping threshold C cost, and what does it bring?";
  shown.about = fmt::format(
      "Threshold sweep, **simulated**: {} readings x {} error ranges x {} thresholds, {} trials a cell.",
      s.interpretations.size(), s.ranges.size(), s.thresholds.size(), s.trials);
  shown.findings = search_sentences(s);
  if (!s.search) shown.findings.push_back(threshold_sentence(s));
  shown.errata = {{"E7", steps_effect(s)}, {"E18", mean_spread_effect(s)}};
  const auto add = [&](std::vector<Table> tables, Table::Shown where) {
    for (Table& table : tables) {
      table.shown = where;
      shown.tables.push_back(std::move(table));
    }
  };
  add(search_tables(s), Table::Shown::first);
  add(table1(s, timings), s.search ? Table::Shown::detail : Table::Shown::first);
  Table cells = sweep_table(s, timings);
  const bool is_long = cells.rows.size() > kMostCells;
  add({std::move(cells)}, is_long ? Table::Shown::file : Table::Shown::detail);
  return shown;
}

}  // namespace trilat
