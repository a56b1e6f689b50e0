// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "reports/tables/accuracy_words.h"
#include "reports/tables/table.h"
#include "reports/tables/tables.h"

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

// Rows of by_take that have the same names in `key`, added up in the order in which they come.
using TakeKey = std::vector<std::string> (*)(const TakeJointRow&);

Table added_up(const ResultsSummary& s, const std::string& id, const std::string& title, TakeKey key,
               std::vector<TableColumn> names) {
  struct Sum {
    std::uint64_t asked = 0, answered = 0;
    double distance_m = 0.0;
  };
  std::vector<std::pair<std::vector<std::string>, Sum>> sums;
  std::map<std::vector<std::string>, std::size_t> place;
  for (const TakeJointRow& row : s.by_take) {
    const auto [found, is_new] = place.try_emplace(key(row), sums.size());
    if (is_new) sums.emplace_back(found->first, Sum{});
    Sum& sum = sums[found->second].second;
    sum.asked += row.asked;
    sum.answered += row.answered;
    if (row.answered > 0) sum.distance_m += row.mae_m * static_cast<double>(row.answered);
  }
  Table table;
  table.id = usable_id(id + "-" + s.study);
  table.title = title + " (" + about(s, "", s.alignments.front()) + ")";
  table.columns = std::move(names);
  table.columns.insert(table.columns.end(), {{"method", "method", true},
                                             {"asked", "asked"},
                                             {"n", "n"},
                                             {"coverage (%)", "coverage_percent"},
                                             {"MAE (cm)", "mae_cm"}});
  for (const auto& [texts, sum] : sums) {
    std::vector<TableValue> cells;
    for (const std::string& text : texts) cells.push_back(TableValue::of(text));
    cells.insert(
        cells.end(),
        {count_cell(sum.asked), count_cell(sum.answered), percent_cell(share_of(sum.answered, sum.asked)),
         cm_cell(sum.answered == 0 ? kNoNumber : sum.distance_m / static_cast<double>(sum.answered))});
    table.rows.push_back(std::move(cells));
  }
  return table;
}

}  // namespace

std::vector<Table> apart_tables(const ResultsSummary& s) {
  if (s.by_take.empty()) return {};
  return {
      added_up(
          s, "by-take", "Error of each take, all joints together",
          [](const TakeJointRow& r) -> std::vector<std::string> {
            return {r.take, r.participant, r.condition, r.method};
          },
          {{"take", "take", true}, {"participant", "participant", true}, {"condition", "condition", true}}),
      added_up(s, "by-participant", "Error of each participant, all joints together",
               [](const TakeJointRow& r) -> std::vector<std::string> {
                 return {r.participant, r.condition, r.method};
               },
               {{"participant", "participant", true}, {"condition", "condition", true}}),
      added_up(s, "by-joint", "Error of each joint, left and right apart",
               [](const TakeJointRow& r) -> std::vector<std::string> {
                 return {r.joint, r.condition, r.method};
               },
               {{"joint", "joint", true}, {"condition", "condition", true}}),
      added_up(s, "by-take-and-joint", "Error of each joint of each take",
               [](const TakeJointRow& r) -> std::vector<std::string> {
                 return {r.take, r.participant, r.condition, r.joint, r.method};
               },
               {{"take", "take", true},
                {"participant", "participant", true},
                {"condition", "condition", true},
                {"joint", "joint", true}})};
}

Table differences_table(const ResultsSummary& s, const std::string& condition, const std::string& alignment) {
  Table table;
  table.id = usable_id(fmt::format("differences-{}{}", condition.empty() ? "" : condition + "-", alignment));
  table.title =
      fmt::format("Mean absolute error, method less \"{}\", over the samples that both answered ({})",
                  s.reference, about(s, condition, alignment));
  table.columns = {{"joint", "joint", true},
                   {"method", "method", true},
                   {"n", "n", false},
                   {"difference (cm)", "difference_cm", false},
                   {"from", "difference_from_cm", false},
                   {"to", "difference_to_cm", false},
                   {fmt::format("% of {}", s.reference), "percent_of_reference", false},
                   {"from", "percent_from", false},
                   {"to", "percent_to", false},
                   {"% of method", "percent_of_method", false},
                   {"% of all answered", "complete_percent", false},
                   {"from", "complete_percent_from", false},
                   {"to", "complete_percent_to", false},
                   {"differs", "differs", true}};
  for (const DifferenceCell& c : s.differences) {
    if (c.condition != condition || c.alignment != alignment) continue;
    table.rows.push_back({TableValue::of(c.group), TableValue::of(c.method), count_cell(c.n),
                          cm_cell(c.difference_m), cm_cell(c.low_m), cm_cell(c.high_m),
                          TableValue::of(c.percent_of_reference, 1), TableValue::of(c.percent_low, 1),
                          TableValue::of(c.percent_high, 1), TableValue::of(c.percent_of_method, 1),
                          TableValue::of(c.complete_percent, 1), TableValue::of(c.complete_percent_low, 1),
                          TableValue::of(c.complete_percent_high, 1), TableValue::of(verdict_of(s, c))});
  }
  table.notes = {
      fmt::format(
          "Below zero the method is nearer to the truth than \"{}\". Differences are taken sample by sample.",
          s.reference),
      fmt::format("% of {0}: 100 (method - {0}) / {0}. % of method: 100 (method - {0}) / method.",
                  s.reference),
      "% of all answered: of the reference, over the samples that any of the two answers. Where one has no "
      "answer, "
      "the other's error counts for both, so a method neither gains nor loses by not answering.",
      "Differs: the interval of the difference leaves zero out (by a micrometre). Every row is for itself: "
      "of twenty without any difference, one is expected to be said to differ.",
      interval_note(s)};
  return table;
}

Table bodies_table(const ResultsSummary& s, const std::string& condition) {
  Table table;
  table.id = usable_id("bodies-" + condition);
  std::string alignment;
  std::uint64_t bones = 0;
  double truth_m_s3 = kNoNumber;
  for (const BodyCell& c : s.bodies) {
    if (c.condition != condition) continue;
    alignment = c.alignment;
    bones = std::max(bones, c.bones);
    truth_m_s3 = c.truth_jitter_m_s3;
    table.rows.push_back({TableValue::of(c.method), count_cell(c.instants), cm_cell(c.mpjpe_m),
                          cm_cell(c.mpjpe_low_m), cm_cell(c.mpjpe_high_m), cm_cell(c.pa_mpjpe_m),
                          cm_cell(c.pa_mpjpe_low_m), cm_cell(c.pa_mpjpe_high_m), percent_cell(c.pck[0]),
                          percent_cell(c.pck[1]), percent_cell(c.pck[2]), cm_cell(c.bone_length_sd_m),
                          TableValue::of(c.jitter_m_s3, 0)});
  }
  table.title = fmt::format("Whole bodies by method ({})", about(s, condition, alignment));
  table.columns = {{"method", "method", true},
                   {"instants", "instants", false},
                   {"MPJPE (cm)", "mpjpe_cm", false},
                   {"from", "mpjpe_from_cm", false},
                   {"to", "mpjpe_to_cm", false},
                   {"PA-MPJPE (cm)", "pa_mpjpe_cm", false},
                   {"from", "pa_mpjpe_from_cm", false},
                   {"to", "pa_mpjpe_to_cm", false},
                   {"PCK 5 cm (%)", "pck_5cm_percent", false},
                   {"10 cm (%)", "pck_10cm_percent", false},
                   {"15 cm (%)", "pck_15cm_percent", false},
                   {"bones (cm)", "bone_length_sd_cm", false},
                   {"jitter (m/s³)", "jitter_m_s3", false}};
  table.notes = {
      "MPJPE is the mean distance of the joints at one instant, of the instants at which every joint with "
      "ground truth is answered; PA-MPJPE the same after rotation, translation and scale of each instant, "
      "before any other alignment; PCK the share of joints that are that near, where a joint that is not "
      "answered is not near.",
      fmt::format(
          "Bones: standard deviation of the lengths of {} bones within a take. Jitter: mean length of "
          "the third difference times the rate cubed{}.",
          bones,
          std::isfinite(truth_m_s3) ? fmt::format("; that of the truth is {:.0f} m/s³", truth_m_s3) : ""),
      interval_note(s)};
  return table;
}

}  // namespace trilat
