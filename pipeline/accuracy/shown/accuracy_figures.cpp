// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "datasets/base/words.h"
#include "pipeline/accuracy/shown/accuracy_shown.h"

namespace trilat {
namespace {

// Order of the panels, from head to foot; other joints follow.
constexpr std::array<std::string_view, 7> kFromHeadToFoot{"head", "shoulder", "elbow", "wrist",
                                                          "hip",  "knee",     "ankle"};

// The groups that a figure of six panels shows: the average of all, then from head to foot.
std::vector<std::string> first_groups(std::vector<std::string> groups) {
  constexpr std::size_t kMaxPanels = 6;
  const bool has_average = !groups.empty() && groups.back() == kAverageGroup;
  if (has_average) groups.pop_back();
  std::ranges::stable_sort(groups, {}, [](const std::string& group) {
    return std::ranges::find(kFromHeadToFoot, std::string_view(group)) - kFromHeadToFoot.begin();
  });
  groups.resize(std::min(groups.size(), kMaxPanels - has_average));
  if (has_average) groups.insert(groups.begin(), kAverageGroup);
  return groups;
}

// The leading methods' mean errors with intervals, a panel a joint group, the least error on top.
Figure methods_figure(const ResultsSummary& s, const std::string& condition) {
  const std::string& alignment = s.alignments.front();
  Figure figure;
  figure.id = file_name_from("errors-" + (condition.empty() ? "all" : condition));
  figure.title = "Mean error by method and joint";
  figure.caption = fmt::format("{} {}, {}: mean error with its 95 % interval, alignment {}.",
                               s.simulated ? "Simulated" : "Recorded", condition,
                               counted(s.participants, "participant"), alignment);
  if (is_like_the_papers(s, condition)) figure.printed = "table3";
  figure.x_label = "mean error (cm)";
  const std::vector<std::string> methods = leading_methods(s, condition);
  for (const std::string& method : methods) figure.y_names.push_back(row_name(s, method));
  const std::vector<std::string> all = groups_in(s, condition), groups = first_groups(all);
  if (groups.size() < all.size())
    figure.caption += fmt::format(" {} of {} joint groups; the tables have all.", groups.size(), all.size());
  const std::string origin = s.simulated ? "ours, simulated" : "recorded";
  for (std::size_t g = 0; g < groups.size(); ++g) {
    FigureSeries ours{origin, FigureSeries::Style::dots, {}, {}, "nonlinear"};
    ours.panel = g;
    for (std::size_t m = 0; m < methods.size(); ++m) {
      const auto y = static_cast<double>(m);
      if (const Number* e = find_error(s, methods[m], condition, groups[g], alignment))
        ours.points.push_back({e->value * kCentimetresPerMetre, y, e->low * kCentimetresPerMetre,
                               e->high * kCentimetresPerMetre});
    }
    figure.series.push_back(std::move(ours));
    figure.panels.push_back(groups[g]);
  }
  return figure;
}

// Error over a family's sets of sensors, on average over the joint groups.
const Number* find_family(const ResultsSummary& s, const std::string& family, const std::string& condition) {
  return s.numbers.find({.condition = condition,
                         .group = kAverageGroup,
                         .method = family,
                         .alignment = s.alignments.front(),
                         .measure = "distance",
                         .statistic = "mean_of_sets"});
}

// Families named "METHOD, N sensors": error against N.
std::vector<Figure> sensor_counts_figures(const ResultsSummary& s) {
  std::vector<Figure> figures;
  for (const std::string& condition : s.conditions) {
    Figure figure;
    for (const SensorSetGroup& family : s.families) {
      const Number* e = find_family(s, family.name, condition);
      const std::string end = fmt::format(", {} sensors", family.sensors);
      if (!e || !family.name.ends_with(end)) continue;
      const std::string method = family.name.substr(0, family.name.size() - end.size());
      auto series = std::ranges::find_if(figure.series,
                                         [&](const FigureSeries& other) { return other.name == method; });
      if (series == figure.series.end())
        series = figure.series.insert(figure.series.end(),
                                      {method, FigureSeries::Style::line_and_dots, {}, {}, method});
      series->points.push_back({static_cast<double>(family.sensors), e->value * kCentimetresPerMetre,
                                e->low * kCentimetresPerMetre, e->high * kCentimetresPerMetre});
    }
    if (figure.series.empty()) continue;
    figure.id = file_name_from(fmt::format("sensors-{}", condition));
    figure.title =
        fmt::format("Number of sensors, {}, {}{}", s.campaign, condition, s.simulated ? ", simulated" : "");
    figure.caption = fmt::format(
        "{}Mean absolute error over sets of so many sensors, with its interval over participants, average "
        "over the joint groups, alignment {}; over what the methods answer.",
        s.simulated ? "Simulated. " : "", s.alignments.front());
    figure.x_label = "sensors";
    figure.y_label = "mean absolute error (cm)";
    figures.push_back(std::move(figure));
  }
  return figures;
}

}  // namespace

std::vector<Figure> accuracy_figures(const ResultsSummary& s) {
  constexpr std::size_t kFirst = 3;
  std::vector<Figure> figures;
  for (const std::string& condition : s.conditions) figures.push_back(methods_figure(s, condition));
  for (Figure& figure : sensor_counts_figures(s)) figures.push_back(std::move(figure));
  for (std::size_t f = 0; f < kFirst && f < figures.size(); ++f) figures[f].is_first = true;
  return figures;
}

}  // namespace trilat
