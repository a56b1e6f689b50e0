// SPDX-License-Identifier: MIT
#include <algorithm>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "datasets/paper/printed_tables.h"
#include "pipeline/accuracy/shown/accuracy_shown.h"
#include "pipeline/accuracy/shown/accuracy_words.h"

namespace trilat {
namespace {

constexpr const char* kAlignment = "mean";

bool has_condition(const ResultsSummary& s, const std::string& condition) {
  return std::ranges::find(s.conditions, condition) != s.conditions.end();
}

// The paper's column that a method belongs beside: its own is nonlinear, with and without compensation.
double papers_cm(const PrintedTable2::Row& row, const std::string& method) {
  if (method == "nonlinear") return row.without_cm;
  if (method.starts_with("nonlinear, occlusion")) return row.with_cm;
  return kNaN;
}

// Whether a condition is averaged over joints of the paper's part alone.
bool has_the_papers_joints(const ResultsSummary& s, const std::string& condition,
                           const PrintedTable2::Row& printed) {
  return std::ranges::all_of(groups_in(s, condition), [&](const std::string& group) {
    return group == kAverageGroup || std::ranges::find(printed.groups, group) != printed.groups.end();
  });
}

void add_rows(const ResultsSummary& s, const PrintedTable2::Row& printed, Table& table) {
  const std::string occluded = occluded_condition(printed.condition);
  for (const std::string& condition : {occluded, printed.condition}) {
    if (!has_condition(s, condition)) continue;
    const bool is_beside = condition == occluded && has_the_papers_joints(s, condition, printed);
    for (const std::string& method : s.methods) {
      const Number *coverage = find_coverage(s, method, condition, kAverageGroup, kAlignment),
                   *error = find_error(s, method, condition, kAverageGroup, kAlignment);
      if (!coverage) continue;
      table.rows.push_back(
          {TableValue::of(printed.part),
           TableValue::of(std::string(condition == occluded ? "occluded" : "all")), TableValue::of(method),
           TableValue::of(is_beside ? papers_cm(printed, method) : kNaN, 1),
           error ? cm_cell(error->value, error->low, error->high) : cm_cell(kNaN, kNaN, kNaN),
           count_cell(error ? error->n : 0), percent_cell(coverage->value)});
    }
  }
}

}  // namespace

std::vector<Table> table2(const ResultsSummary& summary) {
  if (summary.left_out()) return {};
  const PrintedTable2 printed = printed_table2();
  Table table;
  table.id = "table2";
  table.printed = "table2";
  table.title =
      "Table II: mean absolute error with and without occlusion compensation, the paper's beside ours";
  table.about = fmt::format(
      "{}{} of {} takes, {} participants; alignment: {}", summary.simulated ? "simulated sensors, " : "",
      summary.takes - summary.takes_failed, summary.takes, summary.participants, kAlignment);
  table.columns = {{"part", "part", true},
                   {"samples", "samples", true},
                   {"method", "method", true},
                   {"paper (cm)", "paper_mae_cm"},
                   interval_column(summary.simulated ? "ours, simulated (cm)" : "ours (cm)", "mae_cm"),
                   {"n", "n"},
                   {"coverage (%)", "coverage_percent"}};
  for (const PrintedTable2::Row& row : printed.rows) add_rows(summary, row, table);
  if (table.rows.empty()) return {};
  add_notes(table, "table2", {{"source", printed.source}});
  table.notes.push_back(interval_note(summary));
  add_take_notes(summary, table);
  return {table};
}

}  // namespace trilat
