// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "datasets/paper/printed_tables.h"
#include "reports/claims/claims.h"

namespace trilat {
namespace {

constexpr const char* kTable3 = "table3";
constexpr std::string_view kError = "_mae_cm";  // ends the keys of the columns of groups

// Empty for a column of another kind.
std::string group_of_column(const TableColumn& column) {
  return column.key.ends_with(kError) ? column.key.substr(0, column.key.size() - kError.size())
                                      : std::string();
}

}  // namespace

void add_printed(Table& table, bool simulated) {
  if (table.printed != kTable3) return;
  const PrintedTable3 paper = printed_table3();
  std::vector<std::string> groups;
  for (const TableColumn& column : table.columns)
    if (const std::string group = group_of_column(column); !group.empty()) groups.push_back(group);
  for (std::vector<TableValue>& row : table.rows)
    for (std::size_t c = 0; c < row.size(); ++c) {
      const double cm = printed_cm(paper, groups, group_of_column(table.columns[c]), row.front().text);
      if (std::isfinite(cm)) row[c].beside = fmt::format("paper {:.1f}", cm);
    }
  table.title = "Table III: " + table.title;
  add_notes(table, "table3", {{"source", paper.source}});
  if (simulated) add_notes(table, "table3_simulated");
}

void add_printed(Figure& figure) {
  if (figure.printed != kTable3) return;
  const PrintedTable3 paper = printed_table3();
  for (std::size_t g = 0; g < figure.panels.size(); ++g) {
    FigureSeries series{"the paper", FigureSeries::Style::dots, {}, {}, "truth"};
    series.panel = g;
    series.hollow = true;
    for (std::size_t m = 0; m < figure.y_names.size(); ++m)
      if (const double cm = printed_cm(paper, figure.panels, figure.panels[g], figure.y_names[m]);
          std::isfinite(cm))
        series.points.push_back({cm, static_cast<double>(m)});
    if (!series.points.empty()) figure.series.push_back(std::move(series));
  }
  figure.title += ", the paper's beside ours";
  figure.caption += " Rings: what the paper prints.";
}

}  // namespace trilat
