// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/units.h"
#include "pipeline/accuracy/shown/accuracy_shown.h"
#include "pipeline/accuracy/shown/accuracy_words.h"

namespace trilat {
namespace {

Table detail_table(const ResultsSummary& s, const std::string& condition, const std::string& alignment) {
  using R = SummaryCell;
  const auto axis_m = [](std::size_t axis) { return [=](const R& r) { return r.axis_mae_m[axis]; }; };
  Table table = table_of<R>(
      usable_id(fmt::format("accuracy-{}{}", condition.empty() ? "" : condition + "-", alignment)),
      fmt::format("Position error by joint group and method ({})", about(s, condition, alignment)), s.cells,
      {{"joint", "joint", as_text(&R::group)},
       {"method", "method", as_text(&R::method)},
       {"n", "n", as_count(&R::answered)},
       {"coverage (%)", "coverage_percent", in_percent(&R::coverage)},
       {"MAE (cm)", "mae_cm", in_cm(&R::mae_m, &R::mae_low_m, &R::mae_high_m)},
       {"RMSE (cm)", "rmse_cm", in_cm(&R::rmse_m)},
       {"median (cm)", "median_cm", in_cm(&R::median_m)},
       {"p90 (cm)", "p90_cm", in_cm(&R::p90_m)},
       {"p95 (cm)", "p95_cm", in_cm(&R::p95_m)},
       {"max (cm)", "max_cm", in_cm(&R::max_m)},
       {"MAE x (cm)", "mae_x_cm", in_cm(axis_m(0))},
       {"MAE y (cm)", "mae_y_cm", in_cm(axis_m(1))},
       {"MAE z (cm)", "mae_z_cm", in_cm(axis_m(2))},
       {"iterations", "iterations", as_number(1, &R::mean_iterations)},
       {"statuses", "statuses", as_text([](const R& r) { return statuses_text(r.statuses, r.asked); })}},
      [&](const R& r) { return r.condition == condition && r.alignment == alignment; });
  add_error_notes(s, condition, alignment, "accuracy", table);
  return table;
}

}  // namespace

std::vector<Table> accuracy_tables(const ResultsSummary& summary) {
  std::vector<Table> tables;
  const auto add = [&](Table table) {
    if (!table.rows.empty()) tables.push_back(std::move(table));
  };
  for (const std::string& condition : summary.conditions) {
    for (const std::string& alignment : summary.alignments) {
      add(detail_table(summary, condition, alignment));
      add(differences_table(summary, condition, alignment));
    }
    add(bodies_table(summary, condition));
  }
  return tables;
}

namespace {

// Each single sensor is a row of the other tables.
bool is_of_sets(const MethodFamily& family) { return family.sensors > 1; }

}  // namespace

ResultsSummary without_sets(ResultsSummary s) {
  std::set<std::string> members;
  for (const MethodFamily& family : s.families)
    if (is_of_sets(family) && family.methods.size() > 1)
      members.insert(family.methods.begin(), family.methods.end());
  members.erase(s.reference);
  std::erase_if(s.methods, [&](const std::string& name) { return members.contains(name); });
  const auto is_member = [&](const auto& entry) { return members.contains(entry.method); };
  std::erase_if(s.cells, is_member);
  std::erase_if(s.differences, is_member);
  std::erase_if(s.bodies, is_member);
  return s;
}

}  // namespace trilat
