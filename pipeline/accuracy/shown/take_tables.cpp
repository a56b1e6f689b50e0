// SPDX-License-Identifier: MIT
// Tables by take and by file.
#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <set>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "pipeline/accuracy/shown/accuracy_shown.h"
#include "pipeline/accuracy/shown/accuracy_words.h"

namespace trilat {
namespace {

struct ErrorSum {
  std::uint64_t asked = 0, answered = 0;
  double distance_m = 0.0;
  void add(const TakeJointRow& row) {
    asked += row.asked;
    answered += row.answered;
    if (row.answered > 0) distance_m += row.mae_m * static_cast<double>(row.answered);
  }
  double mean_m() const { return answered == 0 ? kNaN : distance_m / static_cast<double>(answered); }
};

// Errors of one take by method.
struct TakeErrors {
  std::string take, participant;
  std::map<std::string, ErrorSum> methods;
};

std::vector<TakeErrors> errors_by_take(const ResultsSummary& s, const std::string& condition) {
  std::vector<TakeErrors> takes;
  for (const TakeJointRow& row : rows_by_take(s)) {
    if (row.condition != condition) continue;
    auto take = std::ranges::find(takes, row.take, &TakeErrors::take);
    if (take == takes.end()) take = takes.insert(takes.end(), {row.take, row.participant, {}});
    take->methods[row.method].add(row);
  }
  return takes;
}

Table takes_table(const ResultsSummary& s, const std::string& condition) {
  constexpr std::size_t kShownTakes = 10, kShownMethods = 4;
  std::vector<std::string> methods = leading_methods(s, condition);
  methods.resize(std::min(methods.size(), kShownMethods));
  const BestMethod* found = find_best(s, condition, average_group(s));
  const std::string best = found ? found->method : s.reference;
  Table table;
  table.id = file_name_from("takes-" + condition);
  table.title = "By take, the largest error first: mean error in cm of all joints";
  table.about = about(s, condition, s.alignments.front());
  table.columns = {{"take", "take", true}, {"participant", "participant", true}};
  for (const std::string& method : methods) table.columns.push_back({method, method + "_mae_cm"});
  table.columns.push_back({"answered (%)", "answered_percent"});
  std::vector<TakeErrors> takes = errors_by_take(s, condition);
  const auto error_m = [&](const TakeErrors& take) {  // without an answer it comes first
    const auto sum = take.methods.find(best);
    return sum == take.methods.end() || sum->second.answered == 0 ? std::numeric_limits<double>::infinity()
                                                                  : sum->second.mean_m();
  };
  std::ranges::stable_sort(takes, std::ranges::greater{}, error_m);
  for (TakeErrors& take : takes) {
    std::vector<TableValue> cells{TableValue::of(take.take), TableValue::of(take.participant)};
    for (const std::string& method : methods) cells.push_back(cm_cell(take.methods[method].mean_m()));
    cells.push_back(percent_cell(share_of(take.methods[best].answered, take.methods[best].asked)));
    table.rows.push_back(std::move(cells));
  }
  table.first_rows = std::min(table.rows.size(), kShownTakes);
  add_notes(table, "takes", {{"method", best}});
  return table;
}

// One method under one alignment, over the joints that it answers.
struct FileRow {
  std::string alignment, method;
  std::uint64_t asked = 0, answered = 0;
  std::size_t groups = 0, joints = 0;
  double mae_m = kNaN, low_m = kNaN, high_m = kNaN;
  std::array<double, 3> bias_m{};
};

// The joints of a condition; of a method those that it answers.
std::size_t count_joints(const std::vector<TakeJointRow>& rows, const std::string& condition,
                         const std::string& method = "") {
  std::set<std::string> joints;
  for (const TakeJointRow& row : rows)
    if (row.condition == condition && (method.empty() || (row.method == method && row.answered > 0)))
      joints.insert(row.joint);
  return joints.size();
}

FileRow file_row(const ResultsSummary& s, const std::string& condition, const std::string& alignment,
                 const std::string& method) {
  FileRow row{.alignment = alignment, .method = method};
  double sum_m = 0.0;
  for (const std::string& group : s.groups) {
    const Number* coverage = find_coverage(s, method, condition, group, alignment);
    if (!coverage) continue;
    row.asked += coverage->n;
    const Number* error = find_error(s, method, condition, group, alignment);
    if (!error) continue;
    row.answered += error->n;
    ++row.groups;
    sum_m += error->value;
    for (std::size_t axis = 0; axis < kAxisNames.size(); ++axis)
      row.bias_m[axis] += s.numbers.value(error->with({.measure = kAxisNames[axis], .statistic = "bias"}));
  }
  for (double& bias_m : row.bias_m) bias_m /= static_cast<double>(row.groups);
  if (row.groups > 0) row.mae_m = sum_m / static_cast<double>(row.groups);
  if (const Number* all = find_error(s, method, condition, average_group(s), alignment)) {
    row.low_m = all->low;
    row.high_m = all->high;
  }
  return row;
}

}  // namespace

std::vector<Table> joint_tables_by_take(const ResultsSummary& s) {
  const std::vector<TakeJointRow> rows = rows_by_take(s);
  if (rows.empty()) return {};
  using R = TakeJointRow;
  return {table_of<R>("by-take-and-joint",
                      {"Error of each joint of each take", about(s, "", s.alignments.front())}, rows,
                      {{"take", "take", as_text(&R::take)},
                       {"participant", "participant", as_text(&R::participant)},
                       {"condition", "condition", as_text(&R::condition)},
                       {"joint", "joint", as_text(&R::joint)},
                       {"method", "method", as_text(&R::method)},
                       {"asked", "asked", as_count(&R::asked)},
                       {"n", "n", as_count(&R::answered)},
                       {"coverage (%)", "coverage_percent",
                        in_percent([](const R& r) { return share_of(r.answered, r.asked); })},
                       {"MAE (cm)", "mae_cm", in_cm(&R::mae_m)}})};
}

std::vector<Table> takes_tables(const ResultsSummary& s) {
  std::vector<Table> tables;
  for (const std::string& condition : s.conditions)
    if (Table table = takes_table(s, condition); table.rows.size() > 1) tables.push_back(std::move(table));
  return tables;
}

Table files_table(const ResultsSummary& s, const std::string& condition) {
  using R = FileRow;
  const std::vector<TakeJointRow> by_take = rows_by_take(s);
  std::vector<FileRow> rows;
  for (const std::string& alignment : s.alignments) {
    const auto first = static_cast<std::ptrdiff_t>(rows.size());
    for (const std::string& method : s.methods) {
      rows.push_back(file_row(s, condition, alignment, method));
      rows.back().joints = count_joints(by_take, condition, method);
    }
    std::ranges::stable_sort(rows.begin() + first, rows.end(), {}, [](const FileRow& row) {
      return row.groups == 0 ? std::numeric_limits<double>::infinity() : row.mae_m;
    });
  }
  const auto bias = [](std::size_t axis) { return in_cm([=](const R& r) { return r.bias_m[axis]; }); };
  Table table = table_of<R>(
      file_name_from("files-" + condition),
      {"Mean error and bias over the joints that a method answers", about(s, condition, "")}, rows,
      {{"alignment", "alignment", as_text(&R::alignment)},
       {"method", "method", as_text(&R::method)},
       {"mean error (cm)", "mae_cm", in_cm(&R::mae_m, &R::low_m, &R::high_m)},
       {"answered (%)", "answered_percent",
        in_percent([](const R& r) { return share_of(r.answered, r.asked); })},
       {"bias x (cm)", "bias_x_cm", bias(0)},
       {"y (cm)", "bias_y_cm", bias(1)},
       {"z (cm)", "bias_z_cm", bias(2)},
       {fmt::format("joints of {}", count_joints(by_take, condition)), "joints", as_count(&R::joints)}});
  table.notes.push_back(interval_note(s));
  return table;
}

}  // namespace trilat
