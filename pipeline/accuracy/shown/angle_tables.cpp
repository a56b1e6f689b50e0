// SPDX-License-Identifier: MIT
// Joint angles: errors, ranges of motion and agreement with the truth.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "pipeline/accuracy/shown/accuracy_shown.h"

namespace trilat {
namespace {

NumberKey of_angle(const char* statistic) { return {.measure = "angle", .statistic = statistic}; }

std::vector<std::string> angles_in(const ResultsSummary& s, const std::string& condition) {
  std::vector<std::string> names;
  for (const Number& number : s.numbers.all())
    if (number.condition == condition && number.measure == "angle" &&
        std::ranges::find(names, number.group) == names.end())
      names.push_back(number.group);
  return names;
}

Table angle_table(const ResultsSummary& s, const std::string& condition) {
  const Numbers& numbers = s.numbers;
  std::vector<NumberKey> rows;
  for (const std::string& angle : angles_in(s, condition))
    for (const std::string& method : s.methods) {
      const NumberKey row{.condition = condition, .group = angle, .method = method};
      if (numbers.find(row.with(of_angle("mean_abs")))) rows.push_back(row);
    }
  Table table = table_of<NumberKey>(
      file_name_from("angles-" + condition),
      {"Joint angles in degrees",
       fmt::format("{}, {}, {}", s.campaign, condition, s.simulated ? "simulated sensors" : "recorded")},
      rows,
      {{"angle", "angle", as_text(&NumberKey::group)},
       {"method", "method", as_text(&NumberKey::method)},
       {"mean absolute error (degrees)", "mae_deg", interval_of(numbers, of_angle("mean_abs"), 1)},
       {"RMSE (degrees)", "rmse_deg", value_of(numbers, of_angle("rms"), 1)},
       {"bias (degrees)", "bias_deg", interval_of(numbers, of_angle("bias"), 1)},
       {"lower limit (degrees)", "lower_limit_deg", interval_of(numbers, of_angle("lower_limit"), 1)},
       {"upper limit (degrees)", "upper_limit_deg", interval_of(numbers, of_angle("upper_limit"), 1)},
       {"range of motion (degrees)", "range_of_motion_deg", value_of(numbers, of_angle("motion_range"), 1)},
       {"the truth's (degrees)", "truth_range_of_motion_deg",
        value_of(numbers, of_angle("true_motion_range"), 1)},
       {"samples", "n", count_of(numbers, of_angle("mean_abs"))}});
  table.notes = {
      "0 degrees: straight, or upright; flexion is positive. Left and right together, before any alignment.",
      fmt::format(
          "Bias: estimate minus truth. Limits hold 95 % of single differences (Bland and Altman 1999, "
          "repeated measurements); repeated are those of {}.",
          s.clusters.at(condition)),
      "Range of motion: of a take, over the instants at which both have the angle; the mean over takes."};
  return table;
}

// The reference and the leading methods that err least, as many as can be distinguished.
std::vector<std::string> shown_methods(const ResultsSummary& s, const std::string& condition) {
  constexpr std::size_t kMaxShown = 3;
  std::vector<std::string> shown{s.reference};
  for (const std::string& method : leading_methods(s, condition))
    if (method != s.reference && shown.size() < kMaxShown) shown.push_back(method);
  return shown;
}

// One dot a take: its mean error against the mean of estimate and truth, in degrees.
std::vector<FigurePoint> dots_of(const ResultsSummary& s, const std::string& condition,
                                 const std::string& angle, const std::string& method) {
  std::vector<FigurePoint> dots;
  for (const Number& bias : s.numbers.all()) {
    if (bias.condition != condition || bias.group != angle || bias.method != method || bias.take.empty() ||
        bias.statistic != "bias")
      continue;
    const double truth_rad = s.numbers.value(bias.with({.statistic = "mean_of_truth"}));
    dots.push_back({kDegreesPerRad * (truth_rad + 0.5 * bias.value), kDegreesPerRad * bias.value});
  }
  return dots;
}

// Difference against mean, a dot a take.
Figure angle_figure(const ResultsSummary& s, const std::string& condition) {
  Figure figure;
  figure.id = file_name_from("agreement-of-angles-" + condition);
  figure.title = "Agreement of joint angles (Bland and Altman)";
  figure.caption = fmt::format(
      "{} {}: difference from the truth against the mean of both, a dot a take; lines: bias and 95 % limits "
      "of {}.",
      s.simulated ? "Simulated" : "Recorded", condition, s.reference);
  figure.x_label = "mean of estimate and truth (degrees)";
  figure.y_label = "estimate - truth (degrees)";
  figure.panels = angles_in(s, condition);
  for (std::size_t p = 0; p < figure.panels.size(); ++p) {
    double least = INFINITY, largest = -INFINITY;
    for (const std::string& method : shown_methods(s, condition)) {
      FigureSeries dots{method, FigureSeries::Style::dots, {}, {}, method};
      dots.panel = p;
      dots.points = dots_of(s, condition, figure.panels[p], method);
      for (const FigurePoint& dot : dots.points) {
        least = std::min(least, dot.x);
        largest = std::max(largest, dot.x);
      }
      figure.series.push_back(std::move(dots));
    }
    for (const char* limit : {"bias", "lower_limit", "upper_limit"}) {
      const double y = kDegreesPerRad * s.numbers.value({.condition = condition,
                                                         .group = figure.panels[p],
                                                         .method = s.reference,
                                                         .measure = "angle",
                                                         .statistic = limit});
      FigureSeries line{"bias and limits of " + s.reference,
                        FigureSeries::Style::line,
                        {{least, y}, {largest, y}},
                        {},
                        s.reference};
      line.panel = p;
      figure.series.push_back(std::move(line));
    }
  }
  return figure;
}

}  // namespace

std::vector<Table> angle_tables(const ResultsSummary& s) {
  std::vector<Table> tables;
  for (const std::string& condition : s.conditions)
    if (!angles_in(s, condition).empty()) tables.push_back(angle_table(s, condition));
  return tables;
}

std::vector<Figure> angle_figures(const ResultsSummary& s) {
  std::vector<Figure> figures;
  for (const std::string& condition : s.conditions)
    if (!angles_in(s, condition).empty()) figures.push_back(angle_figure(s, condition));
  return figures;
}

}  // namespace trilat
