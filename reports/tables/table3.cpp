// SPDX-License-Identifier: MIT
// Methods by joint as an article prints them; of walking, the paper's Table III beside ours.
#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "datasets/paper/printed_tables.h"
#include "datasets/results/table.h"
#include "reports/tables/accuracy_words.h"
#include "reports/tables/tables.h"

namespace trilat {
namespace {

constexpr std::size_t kMostLeading = 8;
constexpr std::array kLeading{"linear", "geometric", "nonlinear", "mean", "range_bearing"};

bool has(const std::vector<std::string>& list, const std::string& name) {
  return std::ranges::find(list, name) != list.end();
}

double average_m(const ResultsSummary& s, const std::string& condition, const std::string& method) {
  const SummaryCell* cell = find_cell(s, method, condition, average_group(s), s.alignments.front());
  return cell && !std::isnan(cell->mae_m) ? cell->mae_m : std::numeric_limits<double>::infinity();
}

TableValue error_cell(const ResultsSummary& s, const std::string& condition, const std::string& alignment,
                      const std::string& group, const std::string& method, double paper_cm) {
  const SummaryCell* c = find_cell(s, method, condition, group, alignment);
  if (!c) return no_cell();
  TableValue value = number_cell(1, c->mae_m * kCentimetresPerMetre, c->mae_low_m * kCentimetresPerMetre,
                                 c->mae_high_m * kCentimetresPerMetre);
  if (const BestMethod* best = find_best(s, condition, group); best && alignment == s.alignments.front())
    value.mark = best->method == method         ? TableValue::Mark::best
                 : has(best->like_best, method) ? TableValue::Mark::like_best
                                                : TableValue::Mark::none;
  if (std::isfinite(paper_cm)) value.beside = fmt::format("paper {:.1f}", paper_cm);
  return value;
}

// Of all joint groups.
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

std::string average_group(const ResultsSummary& s) {
  return s.groups.size() > 1 ? kAverageGroup : s.groups.empty() ? std::string() : s.groups.front();
}

std::vector<std::string> groups_in(const ResultsSummary& s, const std::string& condition) {
  std::vector<std::string> groups;
  for (const std::string& group : s.groups)
    if (std::ranges::any_of(
            s.cells, [&](const SummaryCell& c) { return c.condition == condition && c.group == group; }))
      groups.push_back(group);
  if (groups.size() > 1) groups.emplace_back(kAverageGroup);
  return groups;
}

std::vector<std::string> by_error(const ResultsSummary& s, const std::string& condition,
                                  std::vector<std::string> methods) {
  std::ranges::stable_sort(methods, {}, [&](const std::string& m) { return average_m(s, condition, m); });
  return methods;
}

std::vector<std::string> leading_methods(const ResultsSummary& s, const std::string& condition) {
  std::vector<std::string> leading, sorted = by_error(s, condition, s.methods);
  const auto add = [&](const std::string& name) {
    if (has(s.methods, name) && !has(leading, name) && leading.size() < kMostLeading) leading.push_back(name);
  };
  for (const char* name : kLeading) add(name);
  const auto is_single = [](const std::string& name) {
    return name == "single" || name.starts_with("single ");
  };
  if (const auto single = std::ranges::find_if(sorted, is_single); single != sorted.end()) add(*single);
  add(s.reference);
  if (const BestMethod* best = find_best(s, condition, average_group(s))) add(best->method);
  if (leading.size() < 4 || s.methods.size() <= kMostLeading)
    for (const std::string& name : sorted) add(name);
  return by_error(s, condition, std::move(leading));
}

double printed_table3_cm(const ResultsSummary& s, const std::string& condition, const std::string& group,
                         const std::string& method) {
  const PrintedTable3 printed = printed_table3();
  const std::vector<std::string> ours = groups_in(s, condition);
  const auto is_ours = [&](const PrintedTable3::Row& r) { return has(ours, r.group); };
  if (group == kAverageGroup &&
      !(ours.size() == printed.rows.size() && std::ranges::all_of(printed.rows, is_ours)))
    return kNoNumber;
  const auto column = std::ranges::find(printed.methods, method);
  const auto row = std::ranges::find(printed.rows, group, &PrintedTable3::Row::group);
  if (column == printed.methods.end() || row == printed.rows.end()) return kNoNumber;
  return row->mae_cm[static_cast<std::size_t>(column - printed.methods.begin())];
}

Table article_table(const ResultsSummary& s, const std::string& condition, const std::string& alignment,
                    bool with_paper) {
  const std::vector<std::string> groups = groups_in(s, condition);
  std::vector<std::string> methods = leading_methods(s, condition);
  Table table;
  table.first_rows = methods.size();
  for (const std::string& method : by_error(s, condition, s.methods))
    if (!has(methods, method)) methods.push_back(method);
  table.id = usable_id("errors-" + (condition.empty() ? "all" : condition));
  table.title = fmt::format("{}Mean error in cm by joint and method, with its 95 % interval ({})",
                            with_paper ? "Table III: " : "", about(s, condition, alignment));
  table.columns = {{"method", "method", true}};
  for (const std::string& group : groups) table.columns.push_back(interval_column(group, group + "_mae_cm"));
  bool silent = false;
  for (const std::string& method : methods) {
    std::vector<TableValue> cells{TableValue::of(method)};
    for (const std::string& group : groups)
      cells.push_back(error_cell(s, condition, alignment, group, method,
                                 with_paper ? printed_table3_cm(s, condition, group, method) : kNoNumber));
    cells.push_back(answered_cell(s, condition, method));
    silent |= *cells.back().number < 100.0 * kWhole;
    table.rows.push_back(std::move(cells));
  }
  if (silent)
    table.columns.push_back({"answered (%)", "answered_percent"});
  else
    for (auto& row : table.rows) row.pop_back();
  if (s.left_out()) table.notes.push_back(truth_note(s));
  add_notes(table, "best_in_bold");
  table.notes.push_back(interval_note(s));
  if (with_paper) {
    add_notes(table, "table3", {{"source", printed_table3().source}});
    if (s.simulated) add_notes(table, "table3_simulated");
  }
  add_coverage_note(s, condition, alignment, table);
  add_take_notes(s, table);
  return table;
}

bool is_like_the_papers(const ResultsSummary& s, const std::string& condition) {
  return condition == "walking" && !s.left_out() && s.alignments.front() == "mean";
}

std::vector<Table> article_tables(const ResultsSummary& s, bool with_paper) {
  std::vector<Table> tables;
  for (const std::string& condition : s.conditions) {
    const bool beside = with_paper && is_like_the_papers(s, condition);
    if (Table table = article_table(s, condition, s.alignments.front(), beside); table.columns.size() > 1)
      tables.push_back(std::move(table));
  }
  return tables;
}

}  // namespace trilat
