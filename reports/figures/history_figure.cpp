// SPDX-License-Identifier: MIT
#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "datasets/results/table.h"
#include "reports/figures/figures.h"

namespace trilat {
namespace {

constexpr std::size_t kMaxCurves = 7, kMaxNights = 60;

// The columns whose error moved most from the first to the last night.
std::vector<std::string> moved_most(const std::vector<Night>& nights) {
  std::vector<std::pair<double, std::string>> columns;
  for (const auto& [column, last_m] : nights.back().mean_error_m) {
    const auto first = nights.front().mean_error_m.find(column);
    const bool was_there = first != nights.front().mean_error_m.end();
    columns.emplace_back(was_there ? -std::abs(last_m / first->second - 1.0) : 0.0, column);
  }
  std::ranges::stable_sort(columns, {}, &std::pair<double, std::string>::first);
  std::vector<std::string> names;
  for (const auto& [moved, column] : columns)
    if (names.size() < kMaxCurves) names.push_back(column);
  return names;
}

// "table3: nonlinear, walking", without the unit, which is not that of the figure.
std::string curve_name(const std::string& column) { return column.substr(0, column.rfind(" (")); }

}  // namespace

std::optional<Figure> history_figure(const std::vector<Night>& history) {
  std::vector<Night> nights(history.end() - static_cast<std::ptrdiff_t>(std::min(history.size(), kMaxNights)),
                            history.end());
  std::erase_if(nights, [](const Night& night) { return night.mean_error_m.empty(); });
  if (nights.empty()) return std::nullopt;
  Figure figure;
  figure.id = "history";
  figure.title = "Mean error by night";
  figure.caption = fmt::format(
      "Of {} nights, the averages over the joint groups that moved most; shaded: nights whose change was "
      "accepted as the new baseline. No intervals: the gate judges night by night.",
      nights.size());
  figure.y_label = "mean error (cm)";
  for (const Night& night : nights) figure.x_names.push_back(night.time.substr(0, 10));
  for (const std::string& column : moved_most(nights)) {
    FigureSeries series{curve_name(column), FigureSeries::Style::line_and_dots, {}};
    for (std::size_t n = 0; n < nights.size(); ++n)
      if (const auto error = nights[n].mean_error_m.find(column); error != nights[n].mean_error_m.end())
        series.points.push_back({static_cast<double>(n), error->second * kCentimetresPerMetre});
    figure.series.push_back(std::move(series));
  }
  for (std::size_t n = 0; n < nights.size(); ++n)
    if (nights[n].verdict == NightVerdict::accepted)
      figure.bands.push_back({static_cast<double>(n) - 0.4, static_cast<double>(n) + 0.4, "accepted"});
  return figure;
}

std::vector<std::string> history_sentences(const std::vector<Night>& history) {
  if (history.empty()) return {};
  const Night& last = history.back();
  std::vector<std::string> sentences;
  const std::string night = last.time.substr(0, 10);
  if (last.verdict == NightVerdict::accepted)
    sentences.push_back(
        fmt::format("**Night {}**: its results became the baseline: {}.", night, last.reason));
  else if (!last.alarms.empty())
    sentences.push_back(fmt::format("**Night {}: {} alarm{}**, the first: {}.", night, last.alarms.size(),
                                    last.alarms.size() == 1 ? "" : "s", last.alarms.front()));
  else if (!last.not_judged.empty())
    sentences.push_back(fmt::format("**Night {}: not judged**: {}.", night, last.not_judged.front()));
  else
    sentences.push_back(fmt::format("**Night {}: quiet**, nothing is worse than the baseline.", night));
  const auto accepted = std::find_if(history.rbegin(), history.rend(),
                                     [](const Night& one) { return one.verdict == NightVerdict::accepted; });
  if (accepted != history.rend() && accepted != history.rbegin())
    sentences.push_back(
        fmt::format("The baseline is that of {}: {}.", accepted->time.substr(0, 10), accepted->reason));
  return sentences;
}

}  // namespace trilat
