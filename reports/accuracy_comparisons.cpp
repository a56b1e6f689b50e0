// SPDX-License-Identifier: MIT
#include "reports/accuracy_comparisons.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "reports/accuracy_words.h"
#include "reports/table_cells.h"

namespace trilat {
namespace {

std::string verdict_of(const DifferenceCell& cell) {
  if (std::isnan(cell.low_m)) return "–";
  if (!cell.significant()) return "no";
  return cell.difference_m < 0.0 ? "better" : "worse";
}

}  // namespace

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
                   {"differs", "differs", true}};
  for (const DifferenceCell& c : s.differences) {
    if (c.condition != condition || c.alignment != alignment) continue;
    table.rows.push_back({TableValue::of(c.group), TableValue::of(c.method), count_cell(c.n),
                          cm_cell(c.difference_m), cm_cell(c.low_m), cm_cell(c.high_m),
                          TableValue::of(c.percent_of_reference, 1), TableValue::of(c.percent_low, 1),
                          TableValue::of(c.percent_high, 1), TableValue::of(c.percent_of_method, 1),
                          TableValue::of(verdict_of(c))});
  }
  table.notes = {
      fmt::format(
          "Below zero the method is nearer to the truth than \"{}\". Differences are taken sample by sample.",
          s.reference),
      fmt::format("% of {0}: 100 (method - {0}) / {0}. % of method: 100 (method - {0}) / method.",
                  s.reference),
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
