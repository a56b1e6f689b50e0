// SPDX-License-Identifier: MIT
#include <algorithm>
#include <functional>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/units.h"
#include "datasets/paper/printed_tables.h"
#include "pipeline/sweep/sweep_tables.h"

namespace trilat {
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
  figure.caption =
      fmt::format("Simulated, {} trials a point, seed {}; band: {}.{}{}", s.trials, s.seed, quantity.interval,
                  left_out.empty() ? "" : fmt::format(" {} more lines are in sweep.csv.", left_out.size()),
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
