// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>

#include <fmt/format.h>

#include "datasets/base/median.h"
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

// The method by which a condition's takes are called odd.
std::string best_in(const ResultsSummary& s, const std::string& condition) {
  const BestMethod* best = find_best(s, condition, average_group(s));
  return best ? best->method : s.reference;
}

constexpr std::size_t kShownTakes = 10;
constexpr double kOdd = 3.5;  // Iglewicz and Hoaglin (1993)

struct TakeErrors {
  const TakeJointRow* row = nullptr;  // its first
  std::map<std::string, ErrorSum> methods;
  // Distance of the best method's error from the median of the condition's takes, in deviations; NaN: no
  // answer.
  double odd = 0.0;
  double far() const { return std::isnan(odd) ? std::numeric_limits<double>::infinity() : std::abs(odd); }
};

std::vector<TakeErrors> errors_by_take(const ResultsSummary& s, const std::string& condition) {
  std::vector<TakeErrors> takes;
  for (const TakeJointRow& row : s.by_take) {
    if (row.condition != condition) continue;
    auto take = std::ranges::find_if(takes, [&](const TakeErrors& t) { return t.row->take == row.take; });
    if (take == takes.end()) take = takes.insert(takes.end(), {&row, {}});
    take->methods[row.method].add(row);
  }
  const std::string best = best_in(s, condition);
  std::vector<double> errors_m, off_m;
  for (TakeErrors& take : takes) {
    const double m = take.methods[best].mean_m();
    if (std::isfinite(m)) errors_m.push_back(m);
    if (!std::isfinite(m)) take.odd = kNoNumber;
  }
  if (errors_m.size() >= 3) {
    const double middle_m = median(errors_m);
    for (const double m : errors_m) off_m.push_back(std::abs(m - middle_m));
    const double deviation_m = 1.4826 * median(off_m);
    for (TakeErrors& take : takes)
      if (deviation_m > 0.0) take.odd = (take.methods[best].mean_m() - middle_m) / deviation_m;
  }
  std::ranges::stable_sort(takes, std::greater{}, &TakeErrors::far);
  return takes;
}

Table takes_table(const ResultsSummary& s, const std::string& condition) {
  std::vector<std::string> methods = leading_methods(s, condition);
  methods.resize(std::min<std::size_t>(methods.size(), 4));
  Table table;
  table.id = usable_id("takes-" + condition);
  table.title = fmt::format("Which take is odd: mean error in cm of all joints ({})",
                            about(s, condition, s.alignments.front()));
  table.columns = {{"take", "take", true}, {"participant", "participant", true}};
  for (const std::string& method : methods) table.columns.push_back({method, method + "_mae_cm"});
  table.columns.insert(
      table.columns.end(),
      {{"answered (%)", "answered_percent"}, {"deviations off", "deviations"}, {"odd", "odd", true}});
  for (TakeErrors& take : errors_by_take(s, condition)) {
    std::vector<TableValue> cells{TableValue::of(take.row->take), TableValue::of(take.row->participant)};
    for (const std::string& method : methods) cells.push_back(cm_cell(take.methods[method].mean_m()));
    const ErrorSum& best = take.methods[best_in(s, condition)];
    cells.insert(cells.end(), {percent_cell(share_of(best.answered, best.asked)), TableValue::of(take.odd, 1),
                               TableValue::of(std::isnan(take.odd) ? "no answer"
                                              : take.far() > kOdd  ? "odd"
                                                                   : "")});
    table.rows.push_back(std::move(cells));
  }
  table.first_rows = std::min(table.rows.size(), kShownTakes);
  add_notes(table, "takes", {{"method", best_in(s, condition)}, {"odd", fmt::format("{:g}", kOdd)}});
  return table;
}

}  // namespace

std::vector<Table> oddity_tables(const ResultsSummary& s) {
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
