// SPDX-License-Identifier: MIT
#include <algorithm>
#include <functional>
#include <numeric>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/units.h"
#include "datasets/paper/printed_tables.h"
#include "pipeline/sweep/sweep_tables.h"
#include "pipeline/sweep/table1.h"

namespace trilat {
namespace {

constexpr const char* kThePapers = "the paper's";
constexpr std::size_t kMostPanels = 12, kMostLines = 6;

// A choice that readings differ in.
using Setting = std::string SweepInterpretation::*;
constexpr Setting kPanelSettings[] = {&SweepInterpretation::rig, &SweepInterpretation::error_model};
constexpr std::pair<const char*, Setting> kLineSettings[] = {
    {"joint", &SweepInterpretation::joint},       {"C in", &SweepInterpretation::threshold_unit},
    {"gradient", &SweepInterpretation::gradient}, {"curvature", &SweepInterpretation::curvature},
    {"stop", &SweepInterpretation::stop},         {"damping", &SweepInterpretation::damping},
    {"start", &SweepInterpretation::start}};

bool differs(const SweepSummary& s, const std::vector<std::size_t>& readings, Setting setting) {
  return std::ranges::any_of(readings, [&](std::size_t r) {
    return s.interpretations[r].*setting != s.interpretations[readings.front()].*setting;
  });
}

std::string panel_of(const SweepSummary& s, const std::vector<std::size_t>& readings, std::size_t reading,
                     const SweepSummary::ErrorRange& range) {
  std::vector<std::string> parts;
  for (const Setting setting : kPanelSettings)
    if (differs(s, readings, setting)) parts.push_back(s.interpretations[reading].*setting);
  parts.push_back(
      fmt::format("{:g}-{:g} cm", range.low_m * kCentimetresPerMetre, range.high_m * kCentimetresPerMetre));
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::string line_of(const SweepSummary& s, const std::vector<std::size_t>& readings, std::size_t reading) {
  std::vector<std::string> parts;
  for (const auto& [name, setting] : kLineSettings)
    if (differs(s, readings, setting))
      parts.push_back(fmt::format("{} {}", name, s.interpretations[reading].*setting));
  return parts.empty() ? std::string("simulated") : fmt::format("{}", fmt::join(parts, ", "));
}

// A quantity that is drawn over the threshold.
struct Quantity {
  const char *id, *title, *y_label, *interval;
  bool logarithmic = false;
  std::function<FigurePoint(const SweepCell&)> of;  // but x
  std::function<double(const PrintedTable1::Row&, std::size_t range)> printed =
      {};  // of the paper; NaN: none
};

std::vector<Quantity> quantities(const SweepSummary& s, const SweepTimings& timings) {
  std::vector<Quantity> all{
      {"error", "Error over the stopping threshold", "mean error (cm)", "95 % interval of the mean", false,
       [](const SweepCell& c) {
         const double cm = c.mae_m * kCentimetresPerMetre,
                      half = c.mae_half_interval_m() * kCentimetresPerMetre;
         return FigurePoint{0.0, cm, cm - half, cm + half};
       },
       [](const PrintedTable1::Row& row, std::size_t r) { return row.error_cm[r]; }},
      {"steps", "Steps over the stopping threshold", "mean number of steps",
       "from the median to the 99th percentile", true,
       [](const SweepCell& c) {
         return FigurePoint{0.0, c.mean_iterations, c.p50_iterations, c.p99_iterations};
       }},
      {"answered", "Answered trials over the stopping threshold", "answered (%)", "none", false,
       [](const SweepCell& c) {
         return FigurePoint{0.0, 100.0 * share_of(c.answered, c.asked)};
       }}};
  if (timings.problems > 0)
    all.push_back({"time", "Time of a solve over the stopping threshold", "time of a solve (us)", "none",
                   true,
                   [&](const SweepCell& c) {
                     return FigurePoint{0.0, solve_us(s, timings, c)};
                   },
                   [](const PrintedTable1::Row& row, std::size_t r) {
                     return row.time_is_below ? SweepCell::kNone : row.time_us[r];
                   }});
  return all;
}

std::string unit_of_threshold(const SweepSummary& s, const std::vector<std::size_t>& readings) {
  return differs(s, readings, &SweepInterpretation::threshold_unit)
             ? std::string("as stated")
             : s.interpretations[readings.front()].threshold_unit;
}

// The paper's numbers, if the sweep has its grid.
std::optional<PrintedTable1> papers(const SweepSummary& s) {
  PrintedTable1 paper = printed_table1();
  if (table1_readings(s, paper).empty()) return std::nullopt;
  return paper;
}

FigureSeries paper_series(const PrintedTable1& paper, const Quantity& quantity, std::size_t range,
                          std::size_t panel) {
  FigureSeries series{kThePapers, FigureSeries::Style::line_and_dots, {}, {}, "truth"};
  series.panel = panel;
  series.hollow = true;
  for (const PrintedTable1::Row& row : paper.rows)
    series.points.push_back({row.threshold, quantity.printed(row, range)});
  return series;
}

Figure figure_of(const SweepSummary& s, const Quantity& quantity) {
  std::vector<std::size_t> readings(s.interpretations.size());
  std::iota(readings.begin(), readings.end(), std::size_t{0});
  const std::optional<PrintedTable1> paper = papers(s);
  Figure figure;
  figure.id = quantity.id;
  figure.title = std::string(quantity.title) + " (simulated)";
  figure.x_label = fmt::format("stopping threshold C ({})", unit_of_threshold(s, readings));
  figure.y_label = quantity.y_label;
  figure.log_x = true;
  figure.log_y = quantity.logarithmic;
  std::set<std::string> lines, left_out;
  for (const std::size_t reading : readings)
    for (std::size_t r = 0; r < s.ranges.size(); ++r) {
      const std::string panel = panel_of(s, readings, reading, s.ranges[r]),
                        line = line_of(s, readings, reading);
      auto place = std::ranges::find(figure.panels, panel);
      if ((place == figure.panels.end() && figure.panels.size() == kMostPanels) ||
          (!lines.contains(line) && lines.size() == kMostLines)) {
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
      for (std::size_t t = 0; t < s.thresholds.size(); ++t) {
        FigurePoint point = quantity.of(s.cell(reading, t, r));
        point.x = s.thresholds[t];
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
