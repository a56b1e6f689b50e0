// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/median.h"
#include "datasets/base/units.h"
#include "datasets/base/words.h"
#include "datasets/paper/printed_tables.h"
#include "evaluators/metrics/statistics.h"
#include "evaluators/solvers/point_estimate.h"
#include "pipeline/sweep/sweep_spec.h"
#include "pipeline/sweep/sweep_tables.h"

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
  shown.about = fmt::format("Threshold sweep, **simulated**: {} x {} x {}, {} trials a cell.",
                            counted(s.interpretations(), "interpretation"), counted(s.ranges, "error range"),
                            counted(s.thresholds, "threshold"), s.trials);
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

namespace {

constexpr const char* kPaperRow = "the paper's";
constexpr std::size_t kMaxPanels = 12, kMaxLines = 6;

const SweepSetting& setting_of(const SweepSummary& s, std::size_t interpretation) {
  return s.cell(interpretation, 0, 0);
}

bool differs(const SweepSummary& s, std::string SweepSetting::*word) {
  return std::ranges::any_of(s.cells,
                             [&](const SweepCell& cell) { return cell.*word != s.cells.front().*word; });
}

// A panel has one rig, error model and range of errors; a line the other choices that interpretations differ
// in.
std::string panel_of(const SweepSummary& s, const SweepSetting& setting) {
  std::vector<std::string> parts;
  for (const auto word : {&SweepSetting::rig, &SweepSetting::error_model})
    if (differs(s, word)) parts.push_back(setting.*word);
  parts.push_back(fmt::format("{:g}-{:g} cm", setting.error_low_m * kCentimetresPerMetre,
                              setting.error_high_m * kCentimetresPerMetre));
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::string line_of(const SweepSummary& s, const SweepSetting& setting) {
  std::vector<std::string> parts;
  for (const SweepChoice& choice : sweep_choices())
    if (choice.word != &SweepSetting::error_model && differs(s, choice.word))
      parts.push_back(fmt::format("{} {}", heading_of(choice), setting.*choice.word));
  return parts.empty() ? std::string("simulated") : fmt::format("{}", fmt::join(parts, ", "));
}

// A quantity that is drawn over the threshold.
struct Quantity {
  const char *id, *title, *y_label, *interval;
  bool logarithmic = false;
  std::function<FigurePoint(std::size_t cell)> of;  // but x
  std::function<double(const PrintedTable1::Row&, std::size_t range)> printed =
      {};  // of the paper; NaN: none
};

std::vector<Quantity> quantities(const SweepSummary& s, const SweepTimings& timings) {
  const auto number = [&s](std::size_t cell, const NumberKey& what) {
    return shown_number(s.numbers, s.cells[cell].key().with(what), 0);
  };
  const auto steps = [&s](std::size_t cell, const char* statistic) {
    return s.value(s.cells[cell], {.measure = "iterations", .statistic = statistic});
  };
  std::vector<Quantity> all{
      {"error", "Error over the stopping threshold", "mean error (cm)", "95 % interval of the mean", false,
       [=](std::size_t c) {
         const TableValue error = number(c, kSweptError);
         return FigurePoint{0.0, *error.number, error.low, error.high};
       },
       [](const PrintedTable1::Row& row, std::size_t r) { return row.error_cm[r]; }},
      {"steps", "Steps over the stopping threshold", "mean number of steps",
       "from the median to the 99th percentile", true,
       [=](std::size_t c) {
         return FigurePoint{0.0, steps(c, "mean"), steps(c, "median"), steps(c, "p99")};
       }},
      {"answered", "Answered trials over the stopping threshold", "answered (%)", "none", false,
       [=](std::size_t c) {
         return FigurePoint{0.0, *number(c, kSweptAnswers).number};
       }}};
  if (timings.problems > 0)
    all.push_back({"time", "Time of a solve over the stopping threshold", "time of a solve (us)", "none",
                   true,
                   [&](std::size_t c) {
                     return FigurePoint{0.0, timings.solve_us.at(c)};
                   },
                   [](const PrintedTable1::Row& row, std::size_t r) {
                     return row.time_is_below ? kNaN : row.time_us[r];
                   }});
  return all;
}

// The paper's numbers, if the sweep has its grid.
std::optional<PrintedTable1> papers(const SweepSummary& s) {
  PrintedTable1 paper = printed_table1();
  if (table1_interpretations(s, paper).empty()) return std::nullopt;
  return paper;
}

FigureSeries paper_series(const PrintedTable1& paper, const Quantity& quantity, std::size_t range,
                          std::size_t panel) {
  FigureSeries series{kPaperRow, FigureSeries::Style::line_and_dots, {}, {}, "truth"};
  series.panel = panel;
  series.hollow = true;
  for (const PrintedTable1::Row& row : paper.rows)
    series.points.push_back({row.threshold, quantity.printed(row, range)});
  return series;
}

Figure figure_of(const SweepSummary& s, const Quantity& quantity) {
  const std::optional<PrintedTable1> paper = papers(s);
  Figure figure;
  figure.id = quantity.id;
  figure.title = std::string(quantity.title) + " (simulated)";
  figure.x_label =
      fmt::format("stopping threshold C ({})",
                  differs(s, &SweepSetting::threshold_unit) ? "as stated" : setting_of(s, 0).threshold_unit);
  figure.y_label = quantity.y_label;
  figure.log_x = true;
  figure.log_y = quantity.logarithmic;
  std::set<std::string> lines, left_out;
  for (std::size_t interpretation = 0; interpretation < s.interpretations(); ++interpretation)
    for (std::size_t r = 0; r < s.ranges; ++r) {
      const SweepSetting& setting = s.cell(interpretation, 0, r);
      const std::string panel = panel_of(s, setting), line = line_of(s, setting);
      auto place = std::ranges::find(figure.panels, panel);
      if ((place == figure.panels.end() && figure.panels.size() == kMaxPanels) ||
          (!lines.contains(line) && lines.size() == kMaxLines)) {
        left_out.insert(panel + line);
        continue;
      }
      lines.insert(line);
      if (place == figure.panels.end()) {
        place = figure.panels.insert(figure.panels.end(), panel);
        if (paper && quantity.printed)
          figure.series.push_back(paper_series(*paper, quantity, r, figure.panels.size() - 1));
      }
      FigureSeries series{line, FigureSeries::Style::band, {}};
      series.panel = static_cast<std::size_t>(place - figure.panels.begin());
      for (std::size_t t = 0; t < s.thresholds; ++t) {
        FigurePoint point = quantity.of(s.number_of(interpretation, t, r));
        point.x = s.cell(interpretation, t, r).threshold;
        series.points.push_back(point);
      }
      std::ranges::sort(series.points, {}, &FigurePoint::x);
      figure.series.push_back(std::move(series));
    }
  figure.caption = fmt::format(
      "Simulated, {} trials a point, seed {}; band: {}.{}{}", s.trials, s.seed, quantity.interval,
      left_out.empty() ? ""
                       : fmt::format(" Not drawn, but in sweep.csv: {}.", counted(left_out.size(), "curve")),
      paper && quantity.printed ? " Rings: what the paper prints." : "");
  return figure;
}

}  // namespace

std::vector<Figure> sweep_figures(const SweepSummary& s, const SweepTimings& timings) {
  std::vector<Figure> figures;
  for (const Quantity& quantity : quantities(s, timings)) {
    figures.push_back(figure_of(s, quantity));
    figures.back().is_first = figures.size() <= 2;
  }
  return figures;
}

}  // namespace trilat
