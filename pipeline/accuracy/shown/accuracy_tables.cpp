// SPDX-License-Identifier: MIT
// Tables of an accuracy study: pivots of its numbers.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "evaluators/solvers/point_estimate.h"
#include "pipeline/accuracy/shown/accuracy_shown.h"
#include "pipeline/accuracy/shown/accuracy_words.h"

namespace trilat {
namespace {

using Row = NumberKey;
using Column = RowColumn<NumberKey>;

const NumberKey kMean{.measure = "distance", .statistic = "mean"};
const NumberKey kAnswered{.measure = "answered", .statistic = "share"};

bool has(const std::vector<std::string>& list, const std::string& name) {
  return std::ranges::find(list, name) != list.end();
}

NumberKey statistic(const char* name) { return {.measure = "distance", .statistic = name}; }

std::string id_of(const char* kind, const std::string& condition, const std::string& alignment) {
  return file_name_from(fmt::format("{}-{}{}", kind, condition.empty() ? "" : condition + "-", alignment));
}

// Rows by joint group and method, of which anything is asked.
std::vector<Row> rows_of(const ResultsSummary& s, const std::string& condition,
                         const std::string& alignment) {
  std::vector<Row> rows;
  for (const std::string& group : groups_in(s, condition))
    for (const std::string& method : s.methods)
      if (find_coverage(s, method, condition, group, alignment))
        rows.push_back({.condition = condition, .group = group, .method = method, .alignment = alignment});
  return rows;
}

Table detail_table(const ResultsSummary& s, const std::string& condition, const std::string& alignment) {
  const Numbers& numbers = s.numbers;
  std::vector<Column> columns{{"joint", "joint", as_text(&Row::group)},
                              {"method", "method", as_text(&Row::method)},
                              {"n", "n", count_of(numbers, kMean)},
                              {"coverage (%)", "coverage_percent", value_of(numbers, kAnswered, 1)},
                              {"MAE (cm)", "mae_cm", interval_of(numbers, kMean)},
                              {"RMSE (cm)", "rmse_cm", value_of(numbers, statistic("rms"))},
                              {"median (cm)", "median_cm", value_of(numbers, statistic("median"))},
                              {"p90 (cm)", "p90_cm", value_of(numbers, statistic("p90"))},
                              {"p95 (cm)", "p95_cm", value_of(numbers, statistic("p95"))},
                              {"max (cm)", "max_cm", value_of(numbers, statistic("max"))}};
  for (const std::string axis : kAxisNames)
    columns.push_back({"MAE " + axis + " (cm)", "mae_" + axis + "_cm",
                       value_of(numbers, {.measure = axis, .statistic = "mean_abs"})});
  columns.push_back(
      {"iterations", "iterations", value_of(numbers, {.measure = "iterations", .statistic = "mean"}, 1)});
  columns.push_back({"statuses", "statuses", as_text([&](const Row& row) {
                       return statuses_text(numbers, row, solve_status_names());
                     })});
  Table table = table_of<Row>(id_of("accuracy", condition, alignment),
                              {"Position error by joint group and method", about(s, condition, alignment)},
                              rows_of(s, condition, alignment), columns);
  add_error_notes(s, condition, alignment, "accuracy", table);
  return table;
}

TableValue verdict_cell(const ResultsSummary& s, const Row& row) {
  const Number* difference = find_difference(s, row.method, row.condition, row.group, row.alignment);
  if (!difference || std::isnan(difference->low)) return TableValue::of("–");
  if (!is_significant(*difference)) return TableValue::of("no");
  const bool is_better = difference->value < 0.0;
  const std::string verdict = is_better ? "better" : "worse";
  const double coverage = coverage_of(s, row.method, row.condition, row.group, row.alignment);
  if (coverage < kMinCoverage)
    return TableValue::of(fmt::format("{}, where it answers ({:.0f} %)", verdict, 100.0 * coverage));
  return TableValue::marked(verdict, is_better ? TableValue::Mark::good : TableValue::Mark::bad);
}

TableValue error_cell(const ResultsSummary& s, const Row& row) {
  TableValue value = shown_number(s.numbers, row.with(kMean), 1);
  if (const BestMethod* best = find_best(s, row.condition, row.group);
      best && row.alignment == s.alignments.front())
    value.mark = best->method == row.method                 ? TableValue::Mark::best
                 : has(best->not_distinguished, row.method) ? TableValue::Mark::not_distinguished
                                                            : TableValue::Mark::none;
  return value;
}

// The share of the instants that a method answers, over all joint groups.
double answered_share(const ResultsSummary& s, const std::string& condition, const std::string& method) {
  const std::vector<std::string> groups = groups_in(s, condition);  // their average is the last
  return groups.empty() ? kNaN : coverage_of(s, method, condition, groups.back(), s.alignments.front());
}

Table article_table(const ResultsSummary& s, const std::string& condition, const std::string& alignment) {
  std::vector<std::string> methods = leading_methods(s, condition);
  const std::size_t leading = methods.size();
  for (const std::string& method : by_error(s, condition, s.methods))
    if (!has(methods, method)) methods.push_back(method);
  std::vector<Row> rows;
  for (const std::string& method : methods)
    rows.push_back({.condition = condition, .method = method, .alignment = alignment});
  std::vector<Column> columns{
      {"method", "method", as_text([&](const Row& row) { return row_name(s, row.method); })}};
  for (const std::string& group : groups_in(s, condition))
    columns.push_back(
        {group, group + "_mae_cm",
         CellOf{[&s, group](const Row& row) { return error_cell(s, row.with({.group = group})); }, false,
                true}});
  if (std::ranges::any_of(
          methods, [&](const std::string& method) { return answered_share(s, condition, method) < kWhole; }))
    columns.push_back({"answered (%)", "answered_percent",
                       in_percent([&](const Row& row) { return answered_share(s, condition, row.method); })});
  Table table = table_of<Row>(
      file_name_from("errors-" + (condition.empty() ? "all" : condition)),
      {"Mean error in cm by joint and method, with its 95 % interval", about(s, condition, alignment)}, rows,
      columns);
  table.first_rows = leading;
  add_error_notes(s, condition, alignment, "best_in_bold", table);
  return table;
}

}  // namespace

Table differences_table(const ResultsSummary& s, const std::string& condition, const std::string& alignment) {
  const Numbers& numbers = s.numbers;
  std::vector<Row> rows;
  for (const std::string& method : s.methods)
    for (const std::string& group : groups_in(s, condition))
      if (method != s.reference)
        rows.push_back({.condition = condition,
                        .group = group,
                        .method = method,
                        .against = s.reference,
                        .alignment = alignment});
  const NumberKey relative = statistic("relative_difference");
  const auto share_of_method = [&](const Row& row) {
    const double share = numbers.value(row.with(relative));
    const double of_method = 100.0 * share / (1.0 + share);
    return std::isfinite(of_method) ? of_method : kNaN;
  };
  Table table = table_of<Row>(
      id_of("differences", condition, alignment),
      {fmt::format("Mean absolute error, method less \"{}\", over the samples that both answered",
                   s.reference),
       about(s, condition, alignment)},
      rows,
      {{"joint", "joint", as_text(&Row::group)},
       {"method", "method", as_text(&Row::method)},
       {"n", "n", count_of(numbers, statistic("difference"))},
       {"difference (cm)", "difference_cm", interval_of(numbers, statistic("difference"))},
       {fmt::format("% of {}", s.reference), "percent_of_reference", interval_of(numbers, relative, 1)},
       {"% of method", "percent_of_method", as_number(1, share_of_method)},
       {"differs", "differs", CellOf{[&](const Row& row) { return verdict_cell(s, row); }, true}}});
  add_notes(table, "differences", {{"reference", s.reference}});
  table.notes.push_back(interval_note(s));
  return table;
}

Table bodies_table(const ResultsSummary& s, const std::string& condition) {
  const Numbers& numbers = s.numbers;
  const std::string alignment = body_alignment(s);
  const NumberKey jerk{.measure = "jerk", .statistic = "mean"}, bone{.measure = "bone", .statistic = "sd"};
  const auto within = [&](const char* radius) {
    return value_of(numbers, {.alignment = alignment, .measure = "within", .statistic = radius}, 1);
  };
  std::vector<Row> rows;
  std::uint64_t bones = 0;
  for (const std::string& method : s.methods) {
    const Row row{.condition = condition, .method = method};
    bones = std::max(bones, numbers.n(row.with(bone)));
    if (numbers.find(row.with({.alignment = alignment, .measure = "within", .statistic = "5_cm"})))
      rows.push_back(row);
  }
  Table table = table_of<Row>(
      file_name_from("bodies-" + condition), {"Whole bodies by method", about(s, condition, alignment)}, rows,
      {{"method", "method", as_text(&Row::method)},
       {"instants", "instants",
        count_of(numbers, {.alignment = alignment, .measure = "mpjpe", .statistic = "mean"})},
       {"MPJPE (cm)", "mpjpe_cm",
        interval_of(numbers, {.alignment = alignment, .measure = "mpjpe", .statistic = "mean"})},
       {"PA-MPJPE (cm)", "pa_mpjpe_cm", interval_of(numbers, {.measure = "pa_mpjpe", .statistic = "mean"})},
       {"PCK 5 cm (%)", "pck_5cm_percent", within("5_cm")},
       {"10 cm (%)", "pck_10cm_percent", within("10_cm")},
       {"15 cm (%)", "pck_15cm_percent", within("15_cm")},
       {"bones (cm)", "bone_length_sd_cm", value_of(numbers, bone)},
       {"jitter (m/s³)", "jitter_m_s3", value_of(numbers, jerk, 0)}});
  const double truth_m_s3 =
      numbers.value({.condition = condition, .measure = "jerk", .statistic = "mean_of_truth"});
  add_notes(
      table, "bodies",
      {{"bones", std::to_string(bones)},
       {"truth",
        std::isfinite(truth_m_s3) ? fmt::format("; that of the truth is {:.0f} m/s³", truth_m_s3) : ""}});
  table.notes.push_back(interval_note(s));
  return table;
}

Table agreement_table(const ResultsSummary& s, const std::string& condition, const std::string& alignment) {
  const Numbers& numbers = s.numbers;
  std::vector<Row> rows;
  for (const std::string& method : s.methods)
    for (const std::string& group : groups_in(s, condition))
      for (const char* axis : kAxisNames)
        if (group != kAverageGroup)
          rows.push_back({.condition = condition,
                          .group = group,
                          .method = method,
                          .alignment = alignment,
                          .measure = axis});
  Table table = table_of<Row>(
      id_of("agreement", condition, alignment),
      {"Agreement with the truth by axis: bias and 95 % limits",
       fmt::format("{}, {}, {}; alignment: {}", s.campaign, condition,
                   s.simulated ? "simulated sensors" : "recorded", alignment)},
      rows,
      {{"method", "method", as_text(&Row::method)},
       {"joint group", "group", as_text(&Row::group)},
       {"axis", "axis", as_text(&Row::measure)},
       {"bias (cm)", "bias_cm", interval_of(numbers, {.statistic = "bias"}, 1)},
       {"lower limit (cm)", "lower_limit_cm", interval_of(numbers, {.statistic = "lower_limit"}, 1)},
       {"upper limit (cm)", "upper_limit_cm", interval_of(numbers, {.statistic = "upper_limit"}, 1)},
       {"sd of a difference (cm)", "sd_cm", value_of(numbers, {.statistic = "sd"}, 1)}});
  table.notes = {
      fmt::format("Estimate minus truth along the world's axes. Limits hold 95 % of single differences "
                  "(Bland and Altman 1999, repeated measurements); repeated are those of {}.",
                  s.clusters.at(condition))};
  return table;
}

std::vector<Table> agreement_tables(const ResultsSummary& s) {
  std::vector<Table> tables;
  for (const std::string& condition : s.conditions)
    for (const std::string& alignment : s.alignments)
      if (alignment == "none" || alignment == "mean")
        tables.push_back(agreement_table(s, condition, alignment));
  return tables;
}

std::vector<Table> accuracy_tables(const ResultsSummary& s) {
  std::vector<Table> tables;
  const auto add = [&](Table table) {
    if (!table.rows.empty()) tables.push_back(std::move(table));
  };
  for (const std::string& condition : s.conditions) {
    for (const std::string& alignment : s.alignments) {
      add(detail_table(s, condition, alignment));
      add(differences_table(s, condition, alignment));
    }
    add(bodies_table(s, condition));
  }
  return tables;
}

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
