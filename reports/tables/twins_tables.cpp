// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "reports/figures/figures.h"
#include "reports/tables/table.h"
#include "reports/tables/tables.h"

namespace trilat {
namespace {

constexpr double kMedianWithin = 0.25, kTailWithin = 0.40;

std::vector<std::string> once(const TwinsSummary& s, std::string TwinsRow::*member) {
  std::vector<std::string> list;
  for (const TwinsRow& row : s.rows)
    if (std::ranges::find(list, row.*member) == list.end()) list.push_back(row.*member);
  return list;
}

double centimetres(double m) { return m * kCentimetresPerMetre; }

// How many rows of a set agree within a share.
std::string agreement(const TwinsSummary& s, const std::string& set, double TwinsRow::*recorded,
                      double TwinsRow::*simulated, double within) {
  std::size_t cells = 0, near = 0;
  for (const TwinsRow& row : s.rows) {
    if (row.set != set) continue;
    ++cells;
    near += std::abs(row.*simulated / row.*recorded - 1.0) <= within;
  }
  return fmt::format(
      "in {} of {} cells ({:.0f} %)", near, cells,
      100.0 * static_cast<double>(near) / static_cast<double>(std::max<std::size_t>(cells, 1)));
}

Table table_of(const TwinsSummary& s, const std::string& set) {
  Table table;
  table.id = usable_id(set);
  table.title = fmt::format(
      "Two sensors on one person, recorded / simulated twins: the median, then the 90 % point, of the "
      "distance in cm between their joints ({} participants; {} simulated, seed {})",
      set, s.participants, s.seed);
  table.columns = {{"sensors", "pair", true}, {"activity", "activity", true}};
  const std::vector<std::string> groups = once(s, &TwinsRow::group);
  for (const std::string& group : groups) table.columns.push_back({group, group, true});
  for (const std::string& pair : once(s, &TwinsRow::pair))
    for (const std::string& activity : once(s, &TwinsRow::activity)) {
      std::vector<TableValue> cells{TableValue::of(pair), TableValue::of(activity)};
      for (const std::string& group : groups) {
        const auto row = std::ranges::find_if(s.rows, [&](const TwinsRow& r) {
          return r.set == set && r.pair == pair && r.activity == activity && r.group == group;
        });
        cells.push_back(TableValue::of(
            row == s.rows.end()
                ? "-"
                : fmt::format("{:.1f} / {:.1f}; {:.0f} / {:.0f}", centimetres(row->recorded_q50_m),
                              centimetres(row->simulated_q50_m), centimetres(row->recorded_q90_m),
                              centimetres(row->simulated_q90_m))));
      }
      table.rows.push_back(std::move(cells));
    }
  table.notes = {"Recorded: " + s.source + "."};
  return table;
}

}  // namespace

std::vector<Table> twins_tables(const TwinsSummary& s) {
  std::vector<Table> tables;
  for (const std::string& set : once(s, &TwinsRow::set)) tables.push_back(table_of(s, set));
  std::ranges::reverse(tables);  // those that the tracker was not measured on come first
  return tables;
}

std::vector<std::string> twins_sentences(const TwinsSummary& s) {
  std::vector<std::string> sentences;
  for (const std::string& set : once(s, &TwinsRow::set))
    sentences.push_back(
        fmt::format("Simulated twins beside two real sensors, {} participants: medians agree within {:.0f} % "
                    "{}, 90 % points within {:.0f} % {}.",
                    set, 100.0 * kMedianWithin,
                    agreement(s, set, &TwinsRow::recorded_q50_m, &TwinsRow::simulated_q50_m, kMedianWithin),
                    100.0 * kTailWithin,
                    agreement(s, set, &TwinsRow::recorded_q90_m, &TwinsRow::simulated_q90_m, kTailWithin)));
  std::ranges::reverse(sentences);
  return sentences;
}

std::vector<Figure> twins_figures(const TwinsSummary& s) {
  Figure figure;
  figure.id = "disagreement";
  figure.title = "The simulator beside reality: how far two sensors disagree on one joint";
  figure.caption =
      "Each dot is a joint group, activity and pair of sensors. On the line simulated twins are as real "
      "ones.";
  figure.x_label = "recorded (cm)";
  figure.y_label = "simulated (cm)";
  figure.log_x = figure.log_y = true;
  double least = 1e9, most = 0.0;
  for (const std::string& set : once(s, &TwinsRow::set))
    for (const bool tail : {false, true}) {
      FigureSeries series{.name = fmt::format("{}, {}", tail ? "90 % point" : "median", set), .points = {}};
      for (const TwinsRow& row : s.rows) {
        if (row.set != set) continue;
        const double x = centimetres(tail ? row.recorded_q90_m : row.recorded_q50_m),
                     y = centimetres(tail ? row.simulated_q90_m : row.simulated_q50_m);
        series.points.push_back({.x = x, .y = y});
        least = std::min({least, x, y});
        most = std::max({most, x, y});
      }
      figure.series.push_back(std::move(series));
    }
  figure.series.push_back({.name = "alike",
                           .style = FigureSeries::Style::line,
                           .points = {{.x = least, .y = least}, {.x = most, .y = most}}});
  return {figure};
}

}  // namespace trilat
