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

// The paper's own rows stay apart, since its numbers stand beside them.
bool has_printed_row(const std::string& method) {
  return method == "linear" || method == "geometric" || method == "nonlinear";
}

bool answer_alike(const ResultsSummary& s, const std::string& a, const std::string& b) {
  bool any = false;
  for (const SummaryCell& cell : s.cells) {
    if (cell.method != a) continue;
    const SummaryCell* other = find_cell(s, b, cell.condition, cell.group, cell.alignment);
    if (!other || other->asked != cell.asked || other->answered != cell.answered ||
        (other->mae_m != cell.mae_m && cell.answered > 0))
      return false;
    any |= cell.answered > 0;
  }
  return any;
}

void drop_method(ResultsSummary& s, const std::string& method) {
  const auto is_its = [&](const auto& entry) { return entry.method == method; };
  std::erase(s.methods, method);
  std::erase_if(s.legend, is_its);
  std::erase_if(s.cells, is_its);
  std::erase_if(s.differences, is_its);
  std::erase_if(s.bodies, is_its);
  for (BestMethod& best : s.best) std::erase(best.like_best, method);
}

// A method that answers as an earlier one does shares its row.
void join_alike(ResultsSummary& s) {
  for (std::size_t m = 0; m < s.methods.size(); ++m) {
    const std::string method = s.methods[m];
    const auto note = std::ranges::find(s.legend, method, &MethodNote::method);
    if (has_printed_row(method) || note == s.legend.end()) continue;
    MethodNote joined = *note;
    const std::vector<std::string> later(s.methods.begin() + static_cast<std::ptrdiff_t>(m) + 1,
                                         s.methods.end());
    for (const std::string& other : later) {
      if (has_printed_row(other) || other == s.reference || !answer_alike(s, method, other)) continue;
      for (BestMethod& best : s.best)
        if (best.method == other) {
          best.method = method;
          std::erase(best.like_best, method);
        }
      for (const MethodNote& of_other : s.legend)
        if (of_other.method == other) joined.is_brought |= of_other.is_brought;
      drop_method(s, other);
      joined.alike.push_back(other);
    }
    *std::ranges::find(s.legend, method, &MethodNote::method) = joined;
  }
}

}  // namespace

std::string row_name(const ResultsSummary& s, const std::string& method) {
  const auto note = std::ranges::find(s.legend, method, &MethodNote::method);
  std::string name = method;
  if (note != s.legend.end())
    for (const std::string& other : note->alike) name += " = " + other;
  return name;
}

ResultsSummary shown_summary(ResultsSummary s) {
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
  join_alike(s);
  return s;
}

}  // namespace trilat
