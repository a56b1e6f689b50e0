// SPDX-License-Identifier: MIT
// The paper's Table II, and errors stage by stage.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "datasets/base/words.h"
#include "datasets/paper/printed_tables.h"
#include "pipeline/accuracy/shown/accuracy_shown.h"
#include "pipeline/accuracy/shown/accuracy_words.h"
#include "pipeline/errors/error_changes.h"

namespace trilat {
namespace {

// The errors of one condition alone, under a name that all stages share.
ErrorsByJoint of_condition(ErrorsByJoint errors, const std::string& condition) {
  std::erase_if(errors.rows, [&](const TakeJointRow& row) { return row.condition != condition; });
  for (TakeJointRow& row : errors.rows) row.condition.clear();
  errors.conditions = {""};
  return errors;
}

// Change of a method's average.
TableValue change_cell(const ResultsSummary& s, const std::optional<ErrorChanges>& changes,
                       const std::string& method) {
  if (!changes) return no_cell();
  for (const ErrorChange& row : changes->rows)
    if (row.group == average_group(s) && row.method == method)
      return cm_cell(row.difference_m, row.low_m, row.high_m);
  return no_cell();
}

// The conditions of one activity, by stage.
struct StagesOf {
  std::string activity;  // empty: the only one
  std::vector<std::string> conditions;
};

std::vector<StagesOf> activities_of(const ResultsSummary& s, const std::vector<std::string>& stages) {
  std::vector<StagesOf> activities;
  for (const std::string& first : s.conditions) {
    if (!first.ends_with(stages.front())) continue;
    const std::string before = first.substr(0, first.size() - stages.front().size());  // "walking, "
    if (!before.empty() && !before.ends_with(", ")) continue;
    StagesOf& entry = activities.emplace_back();
    entry.activity = before.substr(0, before.find_last_of(','));
    for (const std::string& stage : stages) entry.conditions.push_back(before + stage);
  }
  return activities;
}

const Number* average_error(const ResultsSummary& s, const std::string& method,
                            const std::string& condition) {
  return find_error(s, method, condition, average_group(s), s.alignments.front());
}

// Changes of each stage from the one before; the first stage has none.
std::vector<std::optional<ErrorChanges>> changes_of(const ResultsSummary& s, const StagesOf& of) {
  const ErrorsByJoint all = errors_by_joint(s);
  std::vector<std::optional<ErrorChanges>> changes(1);
  for (std::size_t i = 1; i < of.conditions.size(); ++i)
    changes.push_back(
        changes_between(of_condition(all, of.conditions[i - 1]), of_condition(all, of.conditions[i])));
  return changes;
}

Table stages_table(const ResultsSummary& s, const StagesOf& of, const std::vector<std::string>& stages) {
  Table table;
  table.id = file_name_from(of.activity.empty() ? "stages" : "stages-" + of.activity);
  table.title =
      "Stage by stage: mean error in cm, average of the joint groups, and how it changes from the stage "
      "before";
  table.about = about(s, of.activity, s.alignments.front());
  table.columns = {{"method", "method", true},
                   {"stage", "stage", true},
                   interval_column("change (cm)", "change_cm"),
                   interval_column("error (cm)", "mae_cm"),
                   {"answered (%)", "answered_percent"}};
  const auto changes = changes_of(s, of);
  for (const std::string& method : s.methods)
    for (std::size_t i = 0; i < stages.size(); ++i) {
      const Number* error = average_error(s, method, of.conditions[i]);
      const double answered =
          coverage_of(s, method, of.conditions[i], average_group(s), s.alignments.front());
      table.rows.push_back(
          {TableValue::of(method), TableValue::of(stages[i]), change_cell(s, changes[i], method),
           error ? number_cell(1, error->value * kCentimetresPerMetre, error->low * kCentimetresPerMetre,
                               error->high * kCentimetresPerMetre)
                 : no_cell(),
           std::isfinite(answered) ? percent_cell(answered) : no_cell()});
    }
  add_notes(table, "stages");
  table.notes.push_back(interval_note(s));
  return table;
}

Figure stages_figure(const ResultsSummary& s, const StagesOf& of, const std::vector<std::string>& stages) {
  Figure figure;
  figure.id = file_name_from(of.activity.empty() ? "stages" : "stages-" + of.activity);
  figure.title = "Mean error stage by stage";
  figure.caption = fmt::format(
      "{}{}, {}: mean error over the joint groups with its 95 % interval, each stage with what "
      "the stages above it changed.",
      s.simulated ? "Simulated" : "Recorded", of.activity.empty() ? "" : " " + of.activity,
      counted(s.participants, "participant"));
  figure.x_label = "mean error (cm)";
  figure.y_names = stages;
  for (const std::string& method : s.methods) {
    FigureSeries series{method, FigureSeries::Style::dots, {}, {}, method};
    if (method.find(',') != std::string::npos) series.method.clear();  // the colour of its kind is another's
    for (std::size_t i = 0; i < stages.size(); ++i)
      if (const Number* error = average_error(s, method, of.conditions[i]))
        series.points.push_back({error->value * kCentimetresPerMetre, static_cast<double>(i),
                                 error->low * kCentimetresPerMetre, error->high * kCentimetresPerMetre});
    figure.series.push_back(std::move(series));
  }
  figure.is_first = true;
  return figure;
}

}  // namespace

std::vector<Table> stages_tables(const ResultsSummary& summary, const std::vector<std::string>& stages) {
  std::vector<Table> tables;
  for (const StagesOf& of : activities_of(summary, stages))
    tables.push_back(stages_table(summary, of, stages));
  return tables;
}

std::vector<Figure> stages_figures(const ResultsSummary& summary, const std::vector<std::string>& stages) {
  std::vector<Figure> figures;
  for (const StagesOf& of : activities_of(summary, stages))
    figures.push_back(stages_figure(summary, of, stages));
  return figures;
}

std::vector<std::string> stages_findings(const ResultsSummary& s, const std::vector<std::string>& stages) {
  std::vector<std::string> findings;
  for (const StagesOf& of : activities_of(s, stages)) {
    std::string errors, largest;
    const auto changes = changes_of(s, of);
    double largest_cm = 0.0;
    for (std::size_t i = 0; i < stages.size(); ++i) {
      const Number* error = average_error(s, s.reference, of.conditions[i]);
      if (!error) continue;
      errors += fmt::format("{}{:.1f} cm ({})", errors.empty() ? "" : ", ",
                            error->value * kCentimetresPerMetre, stages[i]);
      const TableValue change = change_cell(s, changes[i], s.reference);
      if (!(std::abs(change.number.value_or(0.0)) > largest_cm)) continue;
      largest_cm = std::abs(*change.number);
      largest = fmt::format(" The largest step is \"{}\": {:+.1f} cm ({:.1f} to {:.1f}).", stages[i],
                            *change.number, change.low, change.high);
    }
    findings.push_back(fmt::format("**{}{}**: `{}` errs by {}, each stage with those before it.{}",
                                   s.simulated ? "Simulated" : "Recorded",
                                   of.activity.empty() ? "" : ", " + of.activity, s.reference, errors,
                                   largest));
  }
  return findings;
}

std::vector<std::string> stages_warnings(ResultsSummary s, const std::vector<std::string>& stages) {
  // what later stages break is what they are there to show
  std::erase_if(s.notes, [](const TakeNote& note) {
    return !note.failed && !note.take.empty() && !note.take.ends_with(".1");
  });
  std::vector<std::string> first;
  for (const StagesOf& of : activities_of(s, stages)) first.push_back(of.conditions.front());
  s.conditions = first;
  return accuracy_warnings(s);
}

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
  table.about = fmt::format("{}{} of {}, {}; alignment: {}", summary.simulated ? "simulated sensors, " : "",
                            summary.takes - summary.takes_failed, counted(summary.takes, "take"),
                            counted(summary.participants, "participant"), kAlignment);
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
