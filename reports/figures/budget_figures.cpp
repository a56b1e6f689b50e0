// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "reports/figures/figures.h"
#include "reports/tables/table.h"
#include "reports/tables/tables.h"

namespace trilat {
namespace {

constexpr double kCm2PerM2 = 1e4;
constexpr const char* kObserved = "observed";

// Rows of all sources together, of one figure.
using Rows = std::vector<const BudgetRow*>;

Figure stacked(const BudgetSummary& s, const Rows& rows) {
  const BudgetRow& first = *rows.front();
  Figure figure;
  figure.id = usable_id(fmt::format("{}-{}", first.condition, first.method));
  figure.title = fmt::format("Error budget of {}, {} (simulated)", first.method, first.condition);
  figure.caption = fmt::format(
      "Simulated: mean square errors of independent sources add. Each part is what its source alone adds; "
      "the dot is what is observed with all together. Alignment: {}; {} participants, seed {}.",
      first.alignment, s.participants, s.seed);
  figure.x_label = "joint";
  figure.y_label = "mean square error (cm²)";
  std::vector<double> top_m2(rows.size(), 0.0);
  std::string below_zero;
  for (const BudgetRow* row : rows) figure.x_names.push_back(row->group);
  for (const std::string& source : s.sources) {
    if (source == "all") continue;
    FigureSeries bars{source, FigureSeries::Style::bars, {}, {}, {}, 0.6};
    for (std::size_t g = 0; g < rows.size(); ++g) {
      const double added = added_m2(s, *rows[g], source);
      if (!std::isfinite(added)) continue;
      if (added < 0.0) {
        below_zero += fmt::format("{}{} at {} ({:.3g} cm²)", below_zero.empty() ? "" : ", ", source,
                                  rows[g]->group, added * kCm2PerM2);
        continue;
      }
      bars.points.push_back({static_cast<double>(g), added * kCm2PerM2, top_m2[g] * kCm2PerM2,
                             (top_m2[g] + added) * kCm2PerM2});
      top_m2[g] += added;
    }
    figure.series.push_back(std::move(bars));
  }
  if (!below_zero.empty())
    figure.caption +=
        " What a source takes away cannot be stacked and is left out, though the table's sum counts it: " +
        below_zero + ".";
  FigureSeries observed{kObserved, FigureSeries::Style::dots, {}, {}, "truth"};
  for (std::size_t g = 0; g < rows.size(); ++g)
    observed.points.push_back({static_cast<double>(g), rows[g]->rmse_m * rows[g]->rmse_m * kCm2PerM2});
  figure.series.push_back(std::move(observed));
  return figure;
}

}  // namespace

std::vector<Figure> budget_figures(const BudgetSummary& s) {
  std::vector<std::pair<std::pair<std::string, std::string>, Rows>> by_method;  // condition, method
  for (const BudgetRow& row : s.rows) {
    if (row.source != "all" || row.group == kAverageGroup || row.alignment != s.rows.front().alignment)
      continue;
    const std::pair key{row.condition, row.method};
    auto found = std::ranges::find_if(by_method, [&](const auto& e) { return e.first == key; });
    if (found == by_method.end()) found = by_method.insert(by_method.end(), {key, {}});
    found->second.push_back(&row);
  }
  std::vector<Figure> figures;
  for (const auto& [key, rows] : by_method) figures.push_back(stacked(s, rows));
  return figures;
}

}  // namespace trilat
