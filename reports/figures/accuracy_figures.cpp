// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "reports/figures/figures.h"
#include "reports/tables/accuracy_words.h"
#include "reports/tables/table.h"

namespace trilat {

namespace {

constexpr std::size_t kMostDrawn = 5;
constexpr std::array kPaperAndMean{"linear", "geometric", "nonlinear", "mean"};
constexpr const char* kMean = "mean with its 95 % interval";

// Of the average over the groups in the first condition and alignment; infinite where there is none, or where
// a method answers too little to be compared by what it answers.
double average_m(const ResultsSummary& s, const std::string& method) {
  if (s.conditions.empty() || s.alignments.empty()) return std::numeric_limits<double>::infinity();
  const SummaryCell* cell = find_cell(s, method, s.conditions.front(), kAverageGroup, s.alignments.front());
  return cell && std::isfinite(cell->mae_m) && cell->coverage() >= kLeastCoverage
             ? cell->mae_m
             : std::numeric_limits<double>::infinity();
}

FigurePoint box_of(const SummaryCell& cell, double x) {
  const auto cm = [](double metres) { return metres * kCentimetresPerMetre; };
  return {x, cm(cell.median_m), cm(cell.p25_m), cm(cell.p75_m), cm(cell.p05_m), cm(cell.p95_m)};
}

FigurePoint mean_of(const SummaryCell& cell, double x) {
  return {x, cell.mae_m * kCentimetresPerMetre, cell.mae_low_m * kCentimetresPerMetre,
          cell.mae_high_m * kCentimetresPerMetre};
}

Figure box_figure(const ResultsSummary& s, const std::string& condition, const std::string& alignment) {
  Figure figure;
  figure.id = usable_id("figure-errors-" + condition);
  figure.title = "Errors by joint (" + about(s, condition, "") + ")";
  figure.caption = fmt::format(
      "{}Boxes: the middle half of the errors with the median; whiskers: from the 5th to the 95th "
      "percentile. Dots: "
      "the mean absolute error with its interval. Alignment: {}.",
      s.simulated ? "Simulated. " : "", alignment);
  figure.x_label = "joint";
  figure.y_label = "error (cm)";
  for (const std::string& group : s.groups)
    if (group != kAverageGroup) figure.x_names.push_back(group);
  const std::vector<std::string> methods = methods_worth_a_figure(s);
  const double width = 0.8 / static_cast<double>(std::max<std::size_t>(1, methods.size()));
  FigureSeries means{kMean, FigureSeries::Style::dots, {}, kMean, "truth"};
  for (std::size_t m = 0; m < methods.size(); ++m) {
    FigureSeries boxes{methods[m], FigureSeries::Style::boxes, {}, {}, methods[m], 0.85 * width};
    for (std::size_t g = 0; g < figure.x_names.size(); ++g) {
      const SummaryCell* cell = find_cell(s, methods[m], condition, figure.x_names[g], alignment);
      if (!cell || cell->answered == 0) continue;
      const double x = static_cast<double>(g) + (static_cast<double>(m) + 0.5) * width - 0.4;
      boxes.points.push_back(box_of(*cell, x));
      means.points.push_back(mean_of(*cell, x));
    }
    if (!boxes.points.empty()) figure.series.push_back(std::move(boxes));
  }
  if (!figure.series.empty()) figure.series.push_back(std::move(means));
  return figure;
}

constexpr double kBest = 1.0, kWorst = 5.0;  // what lies beyond has the colour of the end

}  // namespace

std::vector<std::string> methods_worth_a_figure(const ResultsSummary& s) {
  std::vector<std::string> shown;
  const auto show = [&](const std::string& name) {
    if (shown.size() < kMostDrawn && std::find(shown.begin(), shown.end(), name) == shown.end())
      shown.push_back(name);
  };
  for (const char* name : kPaperAndMean)
    if (std::find(s.methods.begin(), s.methods.end(), name) != s.methods.end()) show(name);
  const auto best = std::min_element(s.methods.begin(), s.methods.end(), [&](const auto& a, const auto& b) {
    return average_m(s, a) < average_m(s, b);
  });
  if (best != s.methods.end()) show(*best);
  if (shown.size() < 2)
    for (const std::string& name : s.methods) show(name);
  return shown;
}

std::vector<Figure> error_box_figures(const ResultsSummary& s) {
  std::vector<Figure> figures;
  if (s.alignments.empty()) return figures;
  for (const std::string& condition : s.conditions)
    if (Figure figure = box_figure(s, condition, s.alignments.front()); !figure.series.empty())
      figures.push_back(std::move(figure));
  return figures;
}

Figure gdop_figure(const GdopMap& map, const ResultsSummary& summary) {
  Figure figure;
  figure.id = usable_id("figure-gdop-" + summary.study);
  figure.title = fmt::format("GDOP of the rig {:g} m above the floor, {}{}", map.height_m, summary.campaign,
                             summary.simulated ? ", simulated" : "");
  figure.caption = fmt::format(
      "How many times the error of a range a trilaterated position is off: the root of the sum of the "
      "variances "
      "along the three axes, for ranges of variance 1. Geometry alone, of the sensors that have the point in "
      "view (70.6 x 60 degrees, 0.5 to 4.5 m). White: fewer than three have. {} and more are one colour. "
      "Calibration of take {}{}.",
      kWorst, map.take, summary.simulated ? "; simulated" : "");
  figure.x_label = "x (m)";
  figure.y_label = "z (m)";
  figure.equal_scales = true;
  figure.map = FigureMap{map.x_m, map.z_m, map.gdop, "GDOP", kBest, kWorst};
  for (std::size_t s = 0; s < map.sensors.size(); ++s)
    figure.series.push_back({fmt::format("{}, {:.2f} m high", map.sensors[s], map.position_m[s][1]),
                             FigureSeries::Style::dots,
                             {{map.position_m[s][0], map.position_m[s][2]}}});
  return figure;
}

}  // namespace trilat
