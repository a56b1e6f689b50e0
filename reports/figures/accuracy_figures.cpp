// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "datasets/paper/printed_tables.h"
#include "reports/figures/figures.h"
#include "reports/tables/accuracy_words.h"
#include "reports/tables/table.h"
#include "reports/tables/tables.h"

namespace trilat {
namespace {

constexpr double kBest = 1.0, kWorst = 5.0;  // what lies beyond has the colour of the end

}  // namespace

Figure methods_figure(const ResultsSummary& s, const std::string& condition, bool with_paper) {
  constexpr std::size_t kMostPanels = 6;
  const std::string& alignment = s.alignments.front();
  Figure figure;
  figure.id = usable_id("errors-" + (condition.empty() ? "all" : condition));
  figure.title =
      fmt::format("Mean error by method and joint{}", with_paper ? ", the paper's beside ours" : "");
  figure.caption = fmt::format("{} {}, {} participant{}: mean error with its 95 % interval, alignment {}{}.",
                               s.simulated ? "Simulated" : "Recorded", condition, s.participants,
                               s.participants == 1 ? "" : "s", alignment,
                               with_paper ? "; rings: what the paper prints" : "");
  figure.x_label = "mean error (cm)";
  figure.y_names = leading_methods(s, condition);
  std::vector<std::string> groups = groups_in(s, condition);
  if (groups.size() > kMostPanels) groups.erase(groups.begin(), groups.end() - kMostPanels);
  const std::string origin = s.simulated ? "ours, simulated" : "recorded";
  for (std::size_t g = 0; g < groups.size(); ++g) {
    FigureSeries ours{origin, FigureSeries::Style::dots, {}, {}, "nonlinear"},
        paper{"the paper", FigureSeries::Style::dots, {}, {}, "truth"};
    ours.panel = paper.panel = g;
    paper.hollow = true;
    for (std::size_t m = 0; m < figure.y_names.size(); ++m) {
      const auto y = static_cast<double>(m);
      if (const SummaryCell* c = find_cell(s, figure.y_names[m], condition, groups[g], alignment))
        ours.points.push_back({c->mae_m * kCentimetresPerMetre, y, c->mae_low_m * kCentimetresPerMetre,
                               c->mae_high_m * kCentimetresPerMetre});
      if (const double printed_cm = printed_table3_cm(groups[g], figure.y_names[m]);
          with_paper && std::isfinite(printed_cm))
        paper.points.push_back({printed_cm, y});
    }
    figure.series.push_back(std::move(ours));
    if (!paper.points.empty()) figure.series.push_back(std::move(paper));
    figure.panels.push_back(groups[g]);
  }
  return figure;
}

Figure gdop_figure(const GdopMap& map, const ResultsSummary& summary) {
  Figure figure;
  figure.id = "gdop";
  figure.title = fmt::format("GDOP of the rig {:g} m above the floor, {}{}", map.height_m, summary.campaign,
                             summary.simulated ? ", simulated" : "");
  figure.caption = fmt::format(
      "How many times the error of a range a trilaterated position is off: the root of the sum of the "
      "variances along the three axes, for ranges of variance 1. Geometry alone, of the sensors (with their "
      "heights) that have the point in view (70.6 x 60 degrees, 0.5 to 4.5 m). White: fewer than three have. "
      "{} and more are one colour. Calibration of take {}{}.",
      kWorst, map.take, summary.simulated ? "; simulated" : "");
  figure.x_label = "x (m)";
  figure.y_label = "z (m)";
  figure.equal_scales = true;
  figure.map = FigureMap{map.x_m, map.z_m, map.gdop, "GDOP", kBest, kWorst};
  for (std::size_t s = 0; s < map.sensors.size(); ++s)
    figure.series.push_back({fmt::format("{}, {:.2f} m", map.sensors[s], map.position_m[s][1]),
                             FigureSeries::Style::dots,
                             {{map.position_m[s][0], map.position_m[s][2]}}});
  return figure;
}

namespace {

// Shares down to this many percent are seen; nothing is drawn of a range without any.
constexpr double kLeastPercent = 1e-4;

FigureSeries bars_of(const std::string& name, const std::vector<double>& percent, std::size_t place,
                     std::size_t places) {
  const double width = 0.8 / static_cast<double>(places);
  FigureSeries series{name, FigureSeries::Style::bars, {}, {}, place == 0 ? name : "", 0.9 * width};
  for (std::size_t b = 0; b < percent.size(); ++b)
    if (percent[b] > 0.0)
      series.points.push_back({static_cast<double>(b) + (static_cast<double>(place) + 0.5) * width - 0.4,
                               percent[b], kLeastPercent, std::max(percent[b], kLeastPercent)});
  return series;
}

std::vector<double> percent_of(const TimeSpread& error) {
  std::vector<double> percent;
  for (std::uint64_t count : error.bins) percent.push_back(100.0 * share_of(count, error.n));
  return percent;
}

Figure histogram(const RecordingSummary& s, const std::string& network) {
  Figure figure;
  figure.id = usable_id("clocks-" + network);
  figure.title = fmt::format("Table IV: clock errors, {} (simulated)", network);
  figure.caption = fmt::format(
      "Simulated: {} frames x {} sensors x {} runs, seed {}; the paper's: its own samples. Shares below {:g} "
      "% cannot be seen.",
      s.frames, s.sensors, s.runs, s.seed, kLeastPercent);
  figure.x_label = "error of the clock (ms)";
  figure.y_label = "share of the frames (%)";
  figure.log_y = true;
  figure.x_names = {"0 to 2", "2 to 4", "4 to 11", "11 to 22", "22 to 33", "33 on"};
  std::vector<const ClockErrorRow*> rows;
  for (const ClockErrorRow& row : s.clocks)
    if (row.network == network && row.error.n > 0) rows.push_back(&row);
  figure.series.push_back(bars_of("the paper's",
                                  percent_of(printed_table4_times(&PrintedTable4::Row::clock_samples)), 0,
                                  rows.size() + 1));
  for (std::size_t k = 0; k < rows.size(); ++k)
    figure.series.push_back(bars_of(rows[k]->method, percent_of(rows[k]->error), k + 1, rows.size() + 1));
  return figure;
}

}  // namespace

std::vector<Figure> clock_figures(const RecordingSummary& s) {
  std::vector<std::string> networks;
  for (const ClockErrorRow& row : s.clocks)
    if (std::ranges::find(networks, row.network) == networks.end()) networks.push_back(row.network);
  std::vector<Figure> figures;
  for (const std::string& network : networks) figures.push_back(histogram(s, network));
  return figures;
}

}  // namespace trilat
