// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "reports/tables/table.h"
#include "reports/tables/tables.h"

namespace trilat {
namespace {

void add_once(std::vector<std::string>& list, const std::string& text) {
  if (std::ranges::find(list, text) == list.end()) list.push_back(text);
}

Table budget_table(const BudgetSummary& s, const std::string& condition, const std::string& alignment) {
  Table table;
  table.id = usable_id(fmt::format("{}-{}", condition, alignment));
  table.title = fmt::format(
      "Error budget, simulated: root mean square error in cm with one source of error alone ({}, {}; "
      "alignment: {}; {} participants, seed {})",
      s.campaign, condition, alignment, s.participants, s.seed);
  table.columns = {{"joint", "joint", true}, {"method", "method", true}};
  for (const std::string& source : s.sources)
    if (source != "all") table.columns.push_back({source, source + "_rmse_cm"});
  table.columns.push_back({"sum", "sum_rmse_cm"});
  table.columns.push_back({"observed", "observed_rmse_cm"});
  table.columns.push_back({"sum / observed", "sum_to_observed"});
  for (const BudgetRow& all : s.rows) {
    if (all.group == kAverageGroup) continue;  // has no RMSE
    if (all.source != "all" || all.condition != condition || all.alignment != alignment) continue;
    std::vector<TableValue> cells{TableValue::of(all.group), TableValue::of(all.method)};
    for (const std::string& source : s.sources) {
      if (source == "all") continue;
      cells.push_back(cm_cell(rmse_of_source_m(s, all, source)));
    }
    const double sum = sum_of_sources_m(s, all);
    cells.push_back(cm_cell(sum));
    cells.push_back(cm_cell(all.rmse_m));
    cells.push_back(TableValue::of(sum / all.rmse_m, 2));
    table.rows.push_back(std::move(cells));
  }
  add_notes(table, "budget",
            {{"mm", fmt::format("{:g}", s.calibration_sigma_m / kMetresPerMillimetre)},
             {"degrees", fmt::format("{:g}", s.calibration_sigma_rad * kDegreesPerRad)}});
  return table;
}

Table sources_table(const BudgetSummary& s) {
  Table table;
  table.id = "sources";
  table.title = "The sources of the error budget (simulated)";
  table.columns = {{"source", "source", true}, {"what it is", "description", true}};
  for (std::size_t k = 0; k < s.sources.size(); ++k)
    table.rows.push_back({TableValue::of(s.sources[k]), TableValue::of(s.descriptions[k])});
  return table;
}

}  // namespace

double rmse_of_source_m(const BudgetSummary& s, const BudgetRow& like, const std::string& source) {
  for (const BudgetRow& row : s.rows)
    if (row.source == source && row.method == like.method && row.condition == like.condition &&
        row.group == like.group && row.alignment == like.alignment)
      return row.rmse_m;
  return kNoNumber;
}

double added_m2(const BudgetSummary& s, const BudgetRow& like, const std::string& source) {
  const double floor_m2 = std::pow(rmse_of_source_m(s, like, "none"), 2);
  return source == "none" ? floor_m2 : std::pow(rmse_of_source_m(s, like, source), 2) - floor_m2;
}

double sum_of_sources_m(const BudgetSummary& s, const BudgetRow& like) {
  double sum_m2 = added_m2(s, like, "none");
  for (const std::string& source : s.sources)
    if (source != "none" && source != "all") sum_m2 += added_m2(s, like, source);
  return sum_m2 < 0.0 ? 0.0 : std::sqrt(sum_m2);
}

std::vector<Table> budget_tables(const BudgetSummary& s) {
  std::vector<std::string> conditions, alignments;
  for (const BudgetRow& row : s.rows) {
    add_once(conditions, row.condition);
    add_once(alignments, row.alignment);
  }
  std::vector<Table> tables;
  for (const std::string& condition : conditions)
    for (const std::string& alignment : alignments)
      if (Table table = budget_table(s, condition, alignment); !table.rows.empty())
        tables.push_back(std::move(table));
  tables.push_back(sources_table(s));
  return tables;
}

}  // namespace trilat
