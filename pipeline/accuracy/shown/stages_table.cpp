// SPDX-License-Identifier: MIT
// Errors stage by stage.
#include <algorithm>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "pipeline/accuracy/shown/accuracy_shown.h"
#include "pipeline/accuracy/shown/accuracy_words.h"
#include "pipeline/errors/error_changes.h"

namespace trilat {
namespace {

// The errors of one condition alone, under a name that all stages share.
ResultsSummary of_condition(ResultsSummary s, const std::string& condition) {
  const auto is_another = [&](const auto& row) { return row.condition != condition; };
  std::erase_if(s.by_take, is_another);
  for (TakeJointRow& row : s.by_take) row.condition.clear();
  s.conditions = {""};
  return s;
}

// How a method's average changes from one condition to another.
TableValue change_cell(const ResultsSummary& s, const std::string& from, const std::string& to,
                       const std::string& method) {
  const auto changes = changes_between(of_condition(s, from), of_condition(s, to));
  if (!changes) return no_cell();
  for (const ErrorChange& row : changes->rows)
    if (row.group == average_group(s) && row.method == method)
      return cm_cell(row.difference_m, row.low_m, row.high_m);
  return no_cell();
}

Table stages_table(const ResultsSummary& s, const std::string& activity,
                   const std::vector<std::string>& conditions, const std::vector<std::string>& stages) {
  const std::string& alignment = s.alignments.front();
  Table table;
  table.id = usable_id("stages-" + activity);
  table.title = fmt::format(
      "Stage by stage: mean error in cm, average of the joint groups, and how it changes "
      "from the stage before ({})",
      about(s, activity, alignment));
  table.columns = {{"stage", "stage", true}};
  for (const std::string& method : s.methods) {
    table.columns.push_back(interval_column(method + " (cm)", method + "_mae_cm"));
    table.columns.push_back(interval_column("change of " + method + " (cm)", method + "_change_cm"));
    table.columns.push_back({"answered by " + method + " (%)", method + "_answered_percent"});
  }
  for (std::size_t i = 0; i < stages.size(); ++i) {
    std::vector<TableValue> cells{TableValue::of(stages[i])};
    for (const std::string& method : s.methods) {
      const SummaryCell* cell = find_cell(s, method, conditions[i], average_group(s), alignment);
      cells.push_back(cell ? cm_cell(cell->mae_m, cell->mae_low_m, cell->mae_high_m) : no_cell());
      cells.push_back(i > 0 ? change_cell(s, conditions[i - 1], conditions[i], method) : no_cell());
      cells.push_back(cell ? percent_cell(cell->coverage()) : no_cell());
    }
    table.rows.push_back(std::move(cells));
  }
  add_notes(table, "stages");
  table.notes.push_back(interval_note(s));
  return table;
}

}  // namespace

std::vector<Table> stages_tables(const ResultsSummary& summary, const std::vector<std::string>& stages) {
  std::vector<Table> tables;
  for (const std::string& first : summary.conditions) {
    if (stages.empty() || !first.ends_with(stages.front())) continue;
    const std::string before = first.substr(0, first.size() - stages.front().size());
    std::vector<std::string> conditions;
    for (const std::string& stage : stages) conditions.push_back(before + stage);
    const std::string activity = before.empty() ? "" : before.substr(0, before.size() - 2);  // without ", "
    tables.push_back(stages_table(summary, activity, conditions, stages));
  }
  return tables;
}

}  // namespace trilat
