// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/units.h"
#include "reports/tables/accuracy_words.h"
#include "reports/tables/table.h"
#include "reports/tables/tables.h"

namespace trilat {
namespace {

// How exactly the truth is known: one sentence a joint group.
void add_floor_notes(const ResultsSummary& s, const std::string& condition, const std::string& alignment,
                     Table& table) {
  for (const TruthFloor& floor : s.truth_floor) {
    if (floor.condition != condition) continue;
    double most_m = kNoNumber;
    for (const SummaryCell& c : s.cells)
      if (c.condition == condition && c.alignment == alignment && c.group == floor.group)
        most_m = std::fmax(most_m, c.one_frame_m);
    std::vector<std::string> known;
    if (std::isfinite(floor.mocap_noise_m))
      known.push_back(fmt::format("noise of at most {:.2f} cm", floor.mocap_noise_m * kCentimetresPerMetre));
    if (std::isfinite(floor.mean_speed_m_s))
      known.push_back(fmt::format("at its mean speed of {:.2f} m/s a clock error of {:g} ms makes {:.2f} cm",
                                  floor.mean_speed_m_s, floor.clock_error_s * 1e3,
                                  floor.clock_m() * kCentimetresPerMetre));
    if (std::isfinite(most_m))
      known.push_back(fmt::format("one instant early or late would change MAE by up to {:.2f} cm",
                                  most_m * kCentimetresPerMetre));
    if (!known.empty())
      table.notes.push_back(fmt::format("Truth of {}: {}.", floor.group, fmt::join(known, "; ")));
  }
}

Table detail_table(const ResultsSummary& s, const std::string& condition, const std::string& alignment) {
  Table table;
  table.id = usable_id(fmt::format("accuracy-{}{}", condition.empty() ? "" : condition + "-", alignment));
  table.title = fmt::format("Position error by joint group and method ({})", about(s, condition, alignment));
  table.columns = {{"joint", "joint", true},
                   {"method", "method", true},
                   {"n", "n", false},
                   {"coverage (%)", "coverage_percent", false},
                   interval_column("MAE (cm)", "mae_cm"),
                   {"RMSE (cm)", "rmse_cm", false},
                   {"median (cm)", "median_cm", false},
                   {"p90 (cm)", "p90_cm", false},
                   {"p95 (cm)", "p95_cm", false},
                   {"max (cm)", "max_cm", false},
                   {"MAE x (cm)", "mae_x_cm", false},
                   {"MAE y (cm)", "mae_y_cm", false},
                   {"MAE z (cm)", "mae_z_cm", false},
                   {"GDOP", "gdop", false},
                   {"iterations", "iterations", false},
                   {"statuses", "statuses", true}};
  for (const SummaryCell& c : s.cells) {
    if (c.condition != condition || c.alignment != alignment) continue;
    table.rows.push_back(
        {TableValue::of(c.group), TableValue::of(c.method), count_cell(c.answered),
         percent_cell(c.coverage()), cm_cell(c.mae_m, c.mae_low_m, c.mae_high_m), cm_cell(c.rmse_m),
         cm_cell(c.median_m), cm_cell(c.p90_m), cm_cell(c.p95_m), cm_cell(c.max_m), cm_cell(c.axis_mae_m[0]),
         cm_cell(c.axis_mae_m[1]), cm_cell(c.axis_mae_m[2]), TableValue::of(c.mean_gdop, 2),
         TableValue::of(c.mean_iterations, 1), TableValue::of(statuses_text(c.statuses, c.asked))});
  }
  table.notes = {
      "MAE is the mean Euclidean distance; n counts instants and joints with a truth that the method "
      "answered; coverage is n over all that have one.",
      "x, y, z are the world's axes, y up.", interval_note(s)};
  if (s.left_out()) table.notes.insert(table.notes.begin(), truth_note(s));
  add_coverage_note(s, condition, alignment, table);
  add_floor_notes(s, condition, alignment, table);
  add_take_notes(s, table);
  return table;
}

}  // namespace

std::vector<Table> accuracy_tables(const ResultsSummary& summary) {
  std::vector<Table> tables;
  const auto add = [&](Table table) {
    if (!table.rows.empty()) tables.push_back(std::move(table));
  };
  for (const std::string& condition : summary.conditions) {
    for (const std::string& alignment : summary.alignments) {
      add(detail_table(summary, condition, alignment));
      add(differences_table(summary, condition, alignment));
    }
    add(bodies_table(summary, condition));
  }
  return tables;
}

}  // namespace trilat
