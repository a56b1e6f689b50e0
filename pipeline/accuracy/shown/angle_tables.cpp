// SPDX-License-Identifier: MIT
// Joint angles: errors, ranges of motion and agreement with the truth.
#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "evaluators/metrics/agreement.h"
#include "evaluators/metrics/cluster_ratios.h"
#include "pipeline/accuracy/shown/accuracy_shown.h"

namespace trilat {
namespace {

constexpr double kDegrees = 1.0 / kRadPerDegree;

// The takes of one angle and method.
using OfTakes = std::vector<const AngleSums*>;

std::vector<std::string> angles_in(const std::vector<AngleSums>& sums, const std::string& condition) {
  std::vector<std::string> names;
  for (const AngleSums& one : sums)
    if (one.condition == condition && std::ranges::find(names, one.angle) == names.end())
      names.push_back(one.angle);
  return names;
}

OfTakes of_takes(const std::vector<AngleSums>& sums, const std::string& condition, const std::string& angle,
                 const std::string& method) {
  OfTakes takes;
  for (const AngleSums& one : sums)
    if (one.condition == condition && one.angle == angle && one.method == method) takes.push_back(&one);
  return takes;
}

// The agreement of a method with the truth, in degrees; each participant is one cluster.
Agreement agreement_of(const OfTakes& takes) {
  std::map<std::string, DifferenceSums> persons;
  for (const AngleSums* one : takes) {
    DifferenceSums& person = persons[one->participant];
    person.n += static_cast<double>(one->n);
    person.sum += kDegrees * one->error;
    person.sum2 += kDegrees * kDegrees * one->error2;
  }
  std::vector<DifferenceSums> all;
  for (const auto& [name, person] : persons) all.push_back(person);
  return limits_of_agreement(all);
}

TableValue absolute_cell(const OfTakes& takes) {
  std::map<std::string, std::pair<double, double>> persons;
  for (const AngleSums* one : takes) {
    persons[one->participant].first += kDegrees * one->absolute;
    persons[one->participant].second += static_cast<double>(one->n);
  }
  std::vector<double> sums, counts;
  double sum = 0.0, n = 0.0;
  for (const auto& [name, person] : persons) {
    sums.push_back(person.first);
    counts.push_back(person.second);
    sum += person.first;
    n += person.second;
  }
  const auto [low, high] = mean_interval(sums, counts);
  return number_cell(1, sum / n, low, high);
}

// Mean over takes, in degrees.
TableValue mean_cell(const OfTakes& takes, const auto& of) {
  double sum = 0.0;
  for (const AngleSums* one : takes) sum += of(*one);
  return number_cell(1, kDegrees * sum / static_cast<double>(takes.size()));
}

Table angle_table(const ResultsSummary& s, const std::vector<AngleSums>& sums, const std::string& condition) {
  Table table{usable_id("angles-" + condition),
              fmt::format("Joint angles in degrees ({}, {}, {})", s.campaign, condition,
                          s.simulated ? "simulated sensors" : "recorded"),
              {{"angle", "angle", true, false},
               {"method", "method", true, false},
               interval_column("mean absolute error (degrees)", "mae_deg"),
               {"RMSE (degrees)", "rmse_deg"},
               interval_column("bias (degrees)", "bias_deg"),
               interval_column("lower limit (degrees)", "lower_limit_deg"),
               interval_column("upper limit (degrees)", "upper_limit_deg"),
               {"range of motion (degrees)", "range_of_motion_deg"},
               {"the truth's (degrees)", "truth_range_of_motion_deg"},
               {"samples", "n"}},
              {},
              {}};
  for (const std::string& angle : angles_in(sums, condition))
    for (const std::string& method : s.methods) {
      const OfTakes takes = of_takes(sums, condition, angle, method);
      if (takes.empty()) continue;
      const Agreement a = agreement_of(takes);
      std::uint64_t n = 0;
      double squares = 0.0;
      for (const AngleSums* one : takes) {
        n += one->n;
        squares += one->error2;
      }
      table.rows.push_back(
          {TableValue::of(angle), TableValue::of(method), absolute_cell(takes),
           number_cell(1, kDegrees * std::sqrt(squares / static_cast<double>(n))),
           number_cell(1, a.bias, a.bias_low, a.bias_high),
           number_cell(1, a.lower, a.lower_low, a.lower_high),
           number_cell(1, a.upper, a.upper_low, a.upper_high),
           mean_cell(takes, [](const AngleSums& one) { return one.most - one.least; }),
           mean_cell(takes, [](const AngleSums& one) { return one.truth_most - one.truth_least; }),
           count_cell(n)});
    }
  table.notes = {
      "0 degrees: straight, or upright; flexion is positive. Left and right together, before any alignment.",
      "Bias: estimate minus truth. Limits hold 95 % of single differences (Bland and Altman 1999, repeated "
      "measurements by participant).",
      "Range of motion: of a take, over the instants at which both have the angle; the mean over takes."};
  return table;
}

// The reference and the leading methods that err least, as many as can be distinguished.
std::vector<std::string> shown_methods(const ResultsSummary& s, const std::string& condition) {
  constexpr std::size_t kMost = 3;
  std::vector<std::string> shown{s.reference};
  for (const std::string& method : leading_methods(s, condition))
    if (method != s.reference && shown.size() < kMost) shown.push_back(method);
  return shown;
}

// Difference against mean, a dot a take.
Figure angle_figure(const ResultsSummary& s, const std::vector<AngleSums>& sums,
                    const std::string& condition) {
  Figure figure;
  figure.id = usable_id("agreement-of-angles-" + condition);
  figure.title = "Agreement of joint angles (Bland and Altman)";
  figure.caption = fmt::format(
      "{} {}: difference from the truth against the mean of both, a dot a take; lines: bias and 95 % limits "
      "of {}.",
      s.simulated ? "Simulated" : "Recorded", condition, s.reference);
  figure.x_label = "mean of estimate and truth (degrees)";
  figure.y_label = "estimate - truth (degrees)";
  figure.panels = angles_in(sums, condition);
  for (std::size_t p = 0; p < figure.panels.size(); ++p) {
    double least = INFINITY, most = -INFINITY;
    for (const std::string& method : shown_methods(s, condition)) {
      FigureSeries dots{method, FigureSeries::Style::dots, {}, {}, method};
      dots.panel = p;
      for (const AngleSums* one : of_takes(sums, condition, figure.panels[p], method)) {
        const auto n = static_cast<double>(one->n);
        dots.points.push_back({kDegrees * (one->truth + 0.5 * one->error) / n, kDegrees * one->error / n});
        least = std::min(least, dots.points.back().x);
        most = std::max(most, dots.points.back().x);
      }
      figure.series.push_back(std::move(dots));
    }
    const Agreement a = agreement_of(of_takes(sums, condition, figure.panels[p], s.reference));
    for (const double y : {a.bias, a.lower, a.upper}) {
      FigureSeries line{"bias and limits of " + s.reference,
                        FigureSeries::Style::line,
                        {{least, y}, {most, y}},
                        {},
                        s.reference};
      line.panel = p;
      figure.series.push_back(std::move(line));
    }
  }
  return figure;
}

}  // namespace

std::vector<Table> angle_tables(const ResultsSummary& s, const std::vector<AngleSums>& sums) {
  std::vector<Table> tables;
  for (const std::string& condition : s.conditions)
    if (!angles_in(sums, condition).empty()) tables.push_back(angle_table(s, sums, condition));
  return tables;
}

std::vector<Figure> angle_figures(const ResultsSummary& s, const std::vector<AngleSums>& sums) {
  std::vector<Figure> figures;
  for (const std::string& condition : s.conditions)
    if (!angles_in(sums, condition).empty()) figures.push_back(angle_figure(s, sums, condition));
  return figures;
}

}  // namespace trilat
