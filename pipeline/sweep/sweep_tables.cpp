// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_tables.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "datasets/base/median.h"
#include "datasets/base/units.h"
#include "evaluators/metrics/statistics.h"
#include "evaluators/solvers/point_estimate.h"
#include "pipeline/sweep/sweep_spec.h"

namespace trilat {
namespace {

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

}  // namespace

std::string heading_of(const SweepChoice& choice) {
  std::string heading = choice.key;
  std::ranges::replace(heading, '_', ' ');
  return heading == "threshold unit" ? "C in" : heading;
}

namespace {

constexpr std::size_t kMaxCells = 200;  // in a table that is shown

// Every number of every cell, with each of its settings in a column.
Table sweep_table(const SweepSummary& s, const SweepTimings& timings) {
  struct R : NumberKey {
    const SweepCell* cell;
    double time_us;
  };
  std::vector<R> rows;
  for (std::size_t c = 0; c < s.cells.size(); ++c)
    rows.push_back({s.cells[c].key(), &s.cells[c], timings.solve_us.at(c)});
  const auto word = [](std::string SweepSetting::*member) {
    return as_text([member](const R& r) { return r.cell->*member; });
  };
  const auto setting = [](double SweepSetting::*member) {
    return [member](const R& r) { return r.cell->*member; };
  };
  const auto number = [&](const char* measure, const char* statistic, int decimals = 2) {
    return value_of(s.numbers, {.measure = measure, .statistic = statistic}, decimals);
  };
  std::vector<RowColumn<R>> columns{{"rig", "rig", word(&SweepSetting::rig)}};
  for (const SweepChoice& choice : sweep_choices())
    columns.push_back({heading_of(choice), choice.key, word(choice.word)});
  const std::vector<RowColumn<R>> numbers{
      {"errors from (cm)", "range_low_cm",
       as_number(-1, kCentimetresPerMetre, setting(&SweepSetting::error_low_m))},
      {"to (cm)", "range_high_cm", as_number(-1, kCentimetresPerMetre, setting(&SweepSetting::error_high_m))},
      {"C", "threshold", as_number(-1, setting(&SweepSetting::threshold))},
      {"asked", "asked", count_of(s.numbers, kSweptAnswers)},
      {"n", "n", count_of(s.numbers, kSweptError)},
      {"answered (%)", "coverage_percent", number("answered", "share", 1)},
      {"mean error (cm)", "mae_cm", interval_of(s.numbers, kSweptError)},
      {"axis mean (cm)", "axis_mean_mae_cm", in_cm([&](const R& r) { return axis_mean_m(s, *r.cell); })},
      {"RMSE (cm)", "rmse_cm", number("distance", "rms")},
      {"p95 (cm)", "p95_cm", number("distance", "p95")},
      {"max (cm)", "max_cm", number("distance", "max")},
      {"start (cm)", "start_mae_cm", number("start", "mean")},
      {"steps", "iterations", number("iterations", "mean")},
      {"p50", "iterations_p50", number("iterations", "median", 0)},
      {"p99", "iterations_p99", number("iterations", "p99", 0)},
      {"max", "iterations_max", number("iterations", "max", 0)},
      {timings.problems > 0 ? "a solve" : "a trial", "time_us", as_number(3, &R::time_us)},
      {"statuses", "statuses",
       as_text([&](const R& r) { return statuses_text(s.numbers, r, solve_status_names()); })}};
  columns.insert(columns.end(), numbers.begin(), numbers.end());
  Table table = table_of<R>(
      "sweep", fmt::format("Every cell of the sweep, simulated; {} trials a cell, seed {}", s.trials, s.seed),
      rows, columns);
  add_notes(table, "sweep");
  return table;
}

// How exactly 5000 trials give a mean, from the spread of ours: the median over interpretations and cells.
std::string mean_spread_effect(const SweepSummary& s) {
  constexpr double kPapersSets = 5000.0;
  std::vector<double> shares;
  for (const SweepCell& cell : s.cells) {
    const Number* mean = s.numbers.find(cell.key().with(kSweptError));
    if (!mean || mean->n < 2) continue;
    const double standard_error_m = 0.5 * (mean->high - mean->low) / student_quantile(mean->n - 1);
    const double share =
        standard_error_m * std::sqrt(static_cast<double>(mean->n) / kPapersSets) / mean->value;
    if (std::isfinite(share)) shares.push_back(share);
  }
  if (shares.empty()) return {};
  return fmt::format(
      "the mean of 5000 of our trials has a standard error of {:.1f} %, the median over interpretations and "
      "cells",
      100.0 * upper_median(shares));
}

// From the largest threshold to the smallest with one gradient, over all interpretations and ranges of
// errors.
std::string threshold_text(const SweepSummary& s, std::size_t large, std::size_t small,
                           const std::string& gradient) {
  std::vector<double> errors, steps;
  double answered = 1.0;
  for (std::size_t i = 0; i < s.interpretations(); ++i)
    for (std::size_t r = 0; s.cell(i, 0, 0).gradient == gradient && r < s.ranges; ++r) {
      const SweepCell &before = s.cell(i, large, r), &after = s.cell(i, small, r);
      answered = std::min({answered, s.value(before, kSweptAnswers), s.value(after, kSweptAnswers)});
      errors.push_back(s.value(after, kSweptError) / s.value(before, kSweptError));
      steps.push_back(s.value(after, kSweptSteps) / s.value(before, kSweptSteps));
    }
  if (!all_finite(errors) || !all_finite(steps))
    return fmt::format("some cells answer nothing with the {} gradient", gradient);
  return fmt::format(
      "{} times the steps with the {} gradient, for {} times the error ({:.0f} % answered at least)",
      span_text(steps), gradient, span_text(errors), 100.0 * answered);
}

std::string threshold_sentence(const SweepSummary& s) {
  std::vector<double> thresholds;
  for (std::size_t t = 0; t < s.thresholds; ++t) thresholds.push_back(s.cell(0, t, 0).threshold);
  const auto [smallest, largest] = std::ranges::minmax_element(thresholds);
  if (*smallest == *largest)
    return fmt::format("One threshold, C = {:g}: there is nothing to compare.", *smallest);
  std::set<std::string> gradients;
  for (const SweepCell& cell : s.cells) gradients.insert(cell.gradient);
  std::string text;
  for (const std::string& gradient : gradients)
    text += (text.empty() ? "" : "; ") +
            threshold_text(s, static_cast<std::size_t>(largest - thresholds.begin()),
                           static_cast<std::size_t>(smallest - thresholds.begin()), gradient);
  return fmt::format(
      "From C = {:g} to C = {:g}, the least and the most over interpretations and ranges of errors: {}.",
      *largest, *smallest, text);
}

}  // namespace

StoredTables sweep_tables(const SweepSummary& s, const SweepTimings& timings) {
  StoredTables shown;
  shown.title = s.study;
  shown.asked = "What does the stopping threshold C cost, and what does it bring?";
  shown.about = fmt::format(
      "Threshold sweep, **simulated**: {} interpretations x {} error ranges x {} thresholds, {} trials a "
      "cell.",
      s.interpretations(), s.ranges, s.thresholds, s.trials);
  shown.findings = {threshold_sentence(s)};
  shown.errata = {{"E18", mean_spread_effect(s)}};
  const auto add = [&](std::vector<Table> tables, Table::Placement where) {
    for (Table& table : tables) {
      table.shown = where;
      shown.tables.push_back(std::move(table));
    }
  };
  add(table1(s, timings), Table::Placement::first);
  Table cells = sweep_table(s, timings);
  const bool is_long = cells.rows.size() > kMaxCells;
  add({std::move(cells)}, is_long ? Table::Placement::file : Table::Placement::detail);
  return shown;
}

}  // namespace trilat
