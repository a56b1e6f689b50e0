// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <set>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "pipeline/accuracy/shown/accuracy_shown.h"
#include "pipeline/accuracy/shown/accuracy_words.h"

namespace trilat {
namespace {

std::string verdict_of(const ResultsSummary& s, const DifferenceCell& cell) {
  if (std::isnan(cell.low_m)) return "–";
  if (!cell.significant()) return "no";
  std::string verdict = cell.difference_m < 0.0 ? "better" : "worse";
  const SummaryCell* own = find_cell(s, cell.method, cell.condition, cell.group, cell.alignment);
  if (own && own->coverage() < kLeastCoverage)
    verdict += fmt::format(", where it answers ({:.0f} %)", 100.0 * own->coverage());
  return verdict;
}

struct ErrorSum {
  std::uint64_t asked = 0, answered = 0;
  double distance_m = 0.0;
  void add(const TakeJointRow& row) {
    asked += row.asked;
    answered += row.answered;
    if (row.answered > 0) distance_m += row.mae_m * static_cast<double>(row.answered);
  }
  double mean_m() const { return answered == 0 ? kNoNumber : distance_m / static_cast<double>(answered); }
};

}  // namespace

std::vector<Table> apart_tables(const ResultsSummary& s) {
  if (s.by_take.empty()) return {};
  using R = TakeJointRow;
  return {table_of<R>("by-take-and-joint",
                      "Error of each joint of each take (" + about(s, "", s.alignments.front()) + ")",
                      s.by_take,
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

namespace {

constexpr std::size_t kShownTakes = 10;

// Errors of one take by method.
struct TakeErrors {
  std::string take, participant;
  std::map<std::string, ErrorSum> methods;
};

std::vector<TakeErrors> errors_by_take(const ResultsSummary& s, const std::string& condition) {
  std::vector<TakeErrors> takes;
  for (const TakeJointRow& row : s.by_take) {
    if (row.condition != condition) continue;
    auto take = std::ranges::find(takes, row.take, &TakeErrors::take);
    if (take == takes.end()) take = takes.insert(takes.end(), {row.take, row.participant, {}});
    take->methods[row.method].add(row);
  }
  return takes;
}

Table takes_table(const ResultsSummary& s, const std::string& condition) {
  std::vector<std::string> methods = leading_methods(s, condition);
  methods.resize(std::min<std::size_t>(methods.size(), 4));
  const BestMethod* found = find_best(s, condition, average_group(s));
  const std::string best = found ? found->method : s.reference;
  Table table;
  table.id = usable_id("takes-" + condition);
  table.title = fmt::format("By take, the largest error first: mean error in cm of all joints ({})",
                            about(s, condition, s.alignments.front()));
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

}  // namespace

std::vector<Table> takes_tables(const ResultsSummary& s) {
  std::vector<Table> tables;
  for (const std::string& condition : s.conditions)
    if (Table table = takes_table(s, condition); table.rows.size() > 1) tables.push_back(std::move(table));
  return tables;
}

Table differences_table(const ResultsSummary& s, const std::string& condition, const std::string& alignment) {
  using R = DifferenceCell;
  Table table = table_of<R>(
      usable_id(fmt::format("differences-{}{}", condition.empty() ? "" : condition + "-", alignment)),
      fmt::format("Mean absolute error, method less \"{}\", over the samples that both answered ({})",
                  s.reference, about(s, condition, alignment)),
      s.differences,
      {{"joint", "joint", as_text(&R::group)},
       {"method", "method", as_text(&R::method)},
       {"n", "n", as_count(&R::n)},
       {"difference (cm)", "difference_cm", in_cm(&R::difference_m, &R::low_m, &R::high_m)},
       {fmt::format("% of {}", s.reference), "percent_of_reference",
        as_number(1, &R::percent_of_reference, &R::percent_low, &R::percent_high)},
       {"% of method", "percent_of_method", as_number(1, &R::percent_of_method)},
       {"differs", "differs", as_text([&](const R& r) { return verdict_of(s, r); })}},
      [&](const R& r) { return r.condition == condition && r.alignment == alignment; });
  add_notes(table, "differences", {{"reference", s.reference}});
  table.notes.push_back(interval_note(s));
  return table;
}

namespace {

// One method under one alignment, over the joints that it answers.
struct FileRow {
  std::string alignment, method;
  std::uint64_t asked = 0, answered = 0;
  std::size_t groups = 0, joints = 0;
  double mae_m = kNoNumber, low_m = kNoNumber, high_m = kNoNumber;
  std::array<double, 3> bias_m{};
};

// The joints of a condition; of a method those that it answers.
std::size_t count_joints(const ResultsSummary& s, const std::string& condition,
                         const std::string& method = "") {
  std::set<std::string> joints;
  for (const TakeJointRow& row : s.by_take)
    if (row.condition == condition && (method.empty() || (row.method == method && row.answered > 0)))
      joints.insert(row.joint);
  return joints.size();
}

FileRow file_row(const ResultsSummary& s, const std::string& condition, const std::string& alignment,
                 const std::string& method) {
  FileRow row{.alignment = alignment, .method = method, .joints = count_joints(s, condition, method)};
  double sum_m = 0.0;
  for (const SummaryCell& cell : s.cells) {
    if (cell.method != method || cell.alignment != alignment || cell.condition != condition ||
        cell.group == kAverageGroup)
      continue;
    row.asked += cell.asked;
    row.answered += cell.answered;
    if (cell.answered == 0) continue;
    ++row.groups;
    sum_m += cell.mae_m;
    for (std::size_t axis = 0; axis < 3; ++axis) row.bias_m[axis] += cell.bias_m[axis];
  }
  for (double& bias_m : row.bias_m) bias_m /= static_cast<double>(row.groups);
  if (row.groups > 0) row.mae_m = sum_m / static_cast<double>(row.groups);
  if (const SummaryCell* all = find_cell(s, method, condition, average_group(s), alignment)) {
    row.low_m = all->mae_low_m;
    row.high_m = all->mae_high_m;
  }
  return row;
}

}  // namespace

Table files_table(const ResultsSummary& s, const std::string& condition) {
  using R = FileRow;
  std::vector<FileRow> rows;
  for (const std::string& alignment : s.alignments) {
    const auto first = static_cast<std::ptrdiff_t>(rows.size());
    for (const std::string& method : s.methods) rows.push_back(file_row(s, condition, alignment, method));
    std::ranges::stable_sort(rows.begin() + first, rows.end(), {}, [](const FileRow& row) {
      return row.groups == 0 ? std::numeric_limits<double>::infinity() : row.mae_m;
    });
  }
  const auto bias = [](std::size_t axis) { return in_cm([=](const R& r) { return r.bias_m[axis]; }); };
  Table table = table_of<R>(
      usable_id("files-" + condition),
      fmt::format("Mean error and bias over the joints that a method answers ({})", about(s, condition, "")),
      rows,
      {{"alignment", "alignment", as_text(&R::alignment)},
       {"method", "method", as_text(&R::method)},
       {"mean error (cm)", "mae_cm", in_cm(&R::mae_m, &R::low_m, &R::high_m)},
       {"answered (%)", "answered_percent",
        in_percent([](const R& r) { return share_of(r.answered, r.asked); })},
       {"bias x (cm)", "bias_x_cm", bias(0)},
       {"y (cm)", "bias_y_cm", bias(1)},
       {"z (cm)", "bias_z_cm", bias(2)},
       {fmt::format("joints of {}", count_joints(s, condition)), "joints", as_count(&R::joints)}});
  table.notes.push_back(interval_note(s));
  return table;
}

Table bodies_table(const ResultsSummary& s, const std::string& condition) {
  using R = BodyCell;
  std::string alignment;
  std::uint64_t bones = 0;
  double truth_m_s3 = kNoNumber;
  const auto is_here = [&](const R& r) { return r.condition == condition; };
  for (const R& r : s.bodies) {
    if (!is_here(r)) continue;
    alignment = r.alignment;
    bones = std::max(bones, r.bones);
    truth_m_s3 = r.truth_jitter_m_s3;
  }
  const auto pck = [](std::size_t k) { return in_percent([=](const R& r) { return r.pck[k]; }); };
  Table table = table_of<R>(
      usable_id("bodies-" + condition),
      fmt::format("Whole bodies by method ({})", about(s, condition, alignment)), s.bodies,
      {{"method", "method", as_text(&R::method)},
       {"instants", "instants", as_count(&R::instants)},
       {"MPJPE (cm)", "mpjpe_cm", in_cm(&R::mpjpe_m, &R::mpjpe_low_m, &R::mpjpe_high_m)},
       {"PA-MPJPE (cm)", "pa_mpjpe_cm", in_cm(&R::pa_mpjpe_m, &R::pa_mpjpe_low_m, &R::pa_mpjpe_high_m)},
       {"PCK 5 cm (%)", "pck_5cm_percent", pck(0)},
       {"10 cm (%)", "pck_10cm_percent", pck(1)},
       {"15 cm (%)", "pck_15cm_percent", pck(2)},
       {"bones (cm)", "bone_length_sd_cm", in_cm(&R::bone_length_sd_m)},
       {"jitter (m/s³)", "jitter_m_s3", as_number(0, &R::jitter_m_s3)}},
      is_here);
  add_notes(
      table, "bodies",
      {{"bones", std::to_string(bones)},
       {"truth",
        std::isfinite(truth_m_s3) ? fmt::format("; that of the truth is {:.0f} m/s³", truth_m_s3) : ""}});
  table.notes.push_back(interval_note(s));
  return table;
}

}  // namespace trilat
