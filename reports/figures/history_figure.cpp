// SPDX-License-Identifier: MIT
#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "datasets/results/table.h"
#include "reports/figures/figures.h"

namespace trilat {
namespace {

constexpr std::size_t kMostTrends = 7, kMostNights = 60;

// Names of the shown cells: averages over the joint groups that moved most, and the first of the others.
std::vector<std::string> shown_cells(const std::vector<HistoryEntry>& nights) {
  std::vector<std::pair<double, std::string>> cells;
  for (const auto& [name, last_m] : nights.back().error_m) {
    if (name.find("average") == std::string::npos) continue;
    const auto first = nights.front().error_m.find(name);
    const double moved = first == nights.front().error_m.end() ? 0.0 : std::abs(last_m / first->second - 1.0);
    cells.emplace_back(-moved, name);
  }
  std::ranges::stable_sort(cells, {}, &std::pair<double, std::string>::first);
  std::vector<std::string> names;
  for (const auto& [moved, name] : cells)
    if (names.size() < kMostTrends) names.push_back(name);
  return names;
}

}  // namespace

std::optional<Figure> history_figure(const History& history) {
  std::vector<HistoryEntry> nights(
      history.entries.end() - static_cast<std::ptrdiff_t>(std::min(history.entries.size(), kMostNights)),
      history.entries.end());
  std::erase_if(nights, [](const HistoryEntry& night) { return night.error_m.empty(); });
  if (nights.empty()) return std::nullopt;
  Figure figure;
  figure.id = "history";
  figure.title = "Mean error by night";
  figure.caption = fmt::format(
      "Of {} nights, the averages over the joint groups that moved most; shaded: nights whose change was "
      "accepted as the new baseline. No intervals: the gate judges night by night.",
      nights.size());
  figure.y_label = "mean error (cm)";
  for (const HistoryEntry& night : nights) figure.x_names.push_back(night.time.substr(0, 10));
  for (const std::string& cell : shown_cells(nights)) {
    FigureSeries series{cell, FigureSeries::Style::line_and_dots, {}};
    for (std::size_t n = 0; n < nights.size(); ++n)
      if (const auto error = nights[n].error_m.find(cell); error != nights[n].error_m.end())
        series.points.push_back({static_cast<double>(n), error->second * kCentimetresPerMetre});
    figure.series.push_back(std::move(series));
  }
  for (std::size_t n = 0; n < nights.size(); ++n)
    if (nights[n].accepted)
      figure.bands.push_back({static_cast<double>(n) - 0.4, static_cast<double>(n) + 0.4, "accepted"});
  return figure;
}

std::vector<std::string> history_sentences(const History& history) {
  if (history.entries.empty()) return {};
  const HistoryEntry& last = history.entries.back();
  std::vector<std::string> sentences;
  const std::string night = last.time.substr(0, 10);
  if (last.accepted)
    sentences.push_back(
        fmt::format("**Night {}**: its results became the baseline: {}.", night, last.reason));
  else if (!last.alarms.empty())
    sentences.push_back(fmt::format("**Night {}: {} alarm{}**, the first: {}.", night, last.alarms.size(),
                                    last.alarms.size() == 1 ? "" : "s", last.alarms.front()));
  else if (!last.not_judged.empty())
    sentences.push_back(fmt::format("**Night {}: not judged**: {}.", night, last.not_judged.front()));
  else
    sentences.push_back(fmt::format("**Night {}: quiet**, nothing is worse than the baseline.", night));
  const auto accepted = std::find_if(history.entries.rbegin(), history.entries.rend(),
                                     [](const HistoryEntry& e) { return e.accepted; });
  if (accepted != history.entries.rend() && accepted != history.entries.rbegin())
    sentences.push_back(
        fmt::format("The baseline is that of {}: {}.", accepted->time.substr(0, 10), accepted->reason));
  return sentences;
}

}  // namespace trilat
