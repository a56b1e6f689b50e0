// SPDX-License-Identifier: MIT
// Methods by joint as an article prints them.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "pipeline/accuracy/shown/accuracy_shown.h"
#include "pipeline/accuracy/shown/accuracy_words.h"

namespace trilat {
namespace {

bool has(const std::vector<std::string>& list, const std::string& name) {
  return std::ranges::find(list, name) != list.end();
}

TableValue error_cell(const ResultsSummary& s, const std::string& condition, const std::string& alignment,
                      const std::string& group, const std::string& method) {
  const SummaryCell* c = find_cell(s, method, condition, group, alignment);
  if (!c) return no_cell();
  TableValue value = number_cell(1, c->mae_m * kCentimetresPerMetre, c->mae_low_m * kCentimetresPerMetre,
                                 c->mae_high_m * kCentimetresPerMetre);
  if (const BestMethod* best = find_best(s, condition, group); best && alignment == s.alignments.front())
    value.mark = best->method == method         ? TableValue::Mark::best
                 : has(best->like_best, method) ? TableValue::Mark::like_best
                                                : TableValue::Mark::none;
  return value;
}

// The share of the instants that a method answers, over all joint groups, in percent.
TableValue answered_cell(const ResultsSummary& s, const std::string& condition, const std::string& method) {
  std::uint64_t asked = 0, answered = 0;
  for (const SummaryCell& c : s.cells) {
    if (c.condition != condition || c.method != method || c.alignment != s.alignments.front() ||
        c.group == kAverageGroup)
      continue;
    asked += c.asked;
    answered += c.answered;
  }
  return percent_cell(share_of(answered, asked));
}

}  // namespace

namespace {

Table article_table(const ResultsSummary& s, const std::string& condition, const std::string& alignment) {
  const std::vector<std::string> groups = groups_in(s, condition);
  std::vector<std::string> methods = leading_methods(s, condition);
  Table table;
  table.first_rows = methods.size();
  for (const std::string& method : by_error(s, condition, s.methods))
    if (!has(methods, method)) methods.push_back(method);
  table.id = usable_id("errors-" + (condition.empty() ? "all" : condition));
  table.title = fmt::format("Mean error in cm by joint and method, with its 95 % interval ({})",
                            about(s, condition, alignment));
  table.columns = {{"method", "method", true}};
  for (const std::string& group : groups) table.columns.push_back(interval_column(group, group + "_mae_cm"));
  bool silent = false;
  for (const std::string& method : methods) {
    std::vector<TableValue> cells{TableValue::of(row_name(s, method))};
    for (const std::string& group : groups)
      cells.push_back(error_cell(s, condition, alignment, group, method));
    cells.push_back(answered_cell(s, condition, method));
    silent |= *cells.back().number < 100.0 * kWhole;
    table.rows.push_back(std::move(cells));
  }
  if (silent)
    table.columns.push_back({"answered (%)", "answered_percent"});
  else
    for (auto& row : table.rows) row.pop_back();
  add_error_notes(s, condition, alignment, "best_in_bold", table);
  return table;
}

}  // namespace

bool is_like_the_papers(const ResultsSummary& s, const std::string& condition) {
  return condition == "walking" && !s.left_out() && s.alignments.front() == "mean";
}

std::vector<Table> article_tables(const ResultsSummary& s) {
  std::vector<Table> tables;
  for (const std::string& condition : s.conditions) {
    Table table = article_table(s, condition, s.alignments.front());
    if (table.columns.size() < 2) continue;
    if (is_like_the_papers(s, condition)) table.printed = "table3";
    tables.push_back(std::move(table));
  }
  return tables;
}

}  // namespace trilat
