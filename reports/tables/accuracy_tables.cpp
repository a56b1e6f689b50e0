// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/units.h"
#include "datasets/paper/printed_tables.h"
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
                   {"MAE (cm)", "mae_cm", false},
                   {"from", "mae_from_cm", false},
                   {"to", "mae_to_cm", false},
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
    table.rows.push_back({TableValue::of(c.group), TableValue::of(c.method), count_cell(c.answered),
                          TableValue::of(100.0 * c.coverage(), 1), cm_cell(c.mae_m), cm_cell(c.mae_low_m),
                          cm_cell(c.mae_high_m), cm_cell(c.rmse_m), cm_cell(c.median_m), cm_cell(c.p90_m),
                          cm_cell(c.p95_m), cm_cell(c.max_m), cm_cell(c.axis_mae_m[0]),
                          cm_cell(c.axis_mae_m[1]), cm_cell(c.axis_mae_m[2]), TableValue::of(c.mean_gdop, 2),
                          TableValue::of(c.mean_iterations, 1),
                          TableValue::of(statuses_text(c.statuses, c.asked))});
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

// The column of the printed table that a method of ours belongs beside, or none.
std::optional<std::size_t> printed_column(const PrintedTable3& printed, const std::string& method) {
  const std::string word = method.substr(0, method.find(' '));
  const auto found = std::find(printed.methods.begin(), printed.methods.end(), word);
  if (found == printed.methods.end()) return std::nullopt;
  return static_cast<std::size_t>(found - printed.methods.begin());
}

// The plain mean of the groups' errors, as the paper's last row; NaN when a group is missing or unanswered.
SummaryCell average_cell(const ResultsSummary& s, const PrintedTable3& printed, const std::string& method,
                         const std::string& condition) {
  SummaryCell average;
  double sum_m = 0.0;
  std::size_t groups = 0;
  for (const auto& row : printed.rows) {
    const SummaryCell* cell = find_cell(s, method, condition, row.group, "mean");
    if (row.group == "average") continue;
    ++groups;
    sum_m += cell ? cell->mae_m : kNoNumber;
    if (!cell) continue;
    average.asked += cell->asked;
    average.answered += cell->answered;
    for (const auto& [status, n] : cell->statuses) average.statuses[status] += n;
  }
  average.mae_m = sum_m / static_cast<double>(groups);
  // the results' own average is of all their groups, which need not be the printed ones
  const SummaryCell* whole = find_cell(s, method, condition, kAverageGroup, "mean");
  if (!whole || whole->asked != average.asked) return average;
  average.mae_low_m = whole->mae_low_m;
  average.mae_high_m = whole->mae_high_m;
  average.one_frame_m = whole->one_frame_m;
  return average;
}

void add_table3_row(Table& table, const PrintedTable3& printed, const PrintedTable3::Row& row,
                    const std::string& method, const SummaryCell& cell) {
  const auto column = printed_column(printed, method);
  const double paper_cm = column ? row.mae_cm[*column] : kNoNumber;
  table.rows.push_back({TableValue::of(row.group), TableValue::of(method), TableValue::of(paper_cm, 1),
                        cm_cell(cell.mae_m), cm_cell(cell.mae_low_m), cm_cell(cell.mae_high_m),
                        TableValue::of(cell.mae_m * kCentimetresPerMetre / paper_cm, 2),
                        cm_cell(cell.one_frame_m), count_cell(cell.answered),
                        TableValue::of(100.0 * cell.coverage(), 1),
                        TableValue::of(statuses_text(cell.statuses, cell.asked))});
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

std::vector<Table> table3(const ResultsSummary& summary) {
  if (summary.left_out()) return {};  // the paper's numbers are of mocap
  const PrintedTable3 printed = printed_table3();
  std::vector<Table> tables;
  for (const std::string& condition : summary.conditions) {
    if (condition != "walking") continue;
    Table table;
    table.id = "table3";
    table.title =
        "Table III: mean absolute error, the paper's beside ours (" + about(summary, condition, "mean") + ")";
    table.columns = {{"joint", "joint", true},
                     {"method", "method", true},
                     {"paper (cm)", "paper_mae_cm", false},
                     {summary.simulated ? "ours, simulated (cm)" : "ours (cm)", "mae_cm", false},
                     {"from", "mae_from_cm", false},
                     {"to", "mae_to_cm", false},
                     {"ours / paper", "ratio", false},
                     {"one frame (cm)", "one_frame_cm", false},
                     {"n", "n", false},
                     {"coverage (%)", "coverage_percent", false},
                     {"statuses", "statuses", true}};
    for (const auto& row : printed.rows)
      for (const std::string& method : summary.methods) {
        const SummaryCell* cell = find_cell(summary, method, condition, row.group, "mean");
        if (row.group == "average")
          add_table3_row(table, printed, row, method, average_cell(summary, printed, method, condition));
        else if (cell)
          add_table3_row(table, printed, row, method, *cell);
      }
    if (table.rows.size() <= summary.methods.size()) continue;  // averages of nothing
    table.notes = {
        "Paper: " + printed.source +
            "; 16 participants, relative movement; geometric uses 3 sensors, the "
            "others 4.",
        "The average is the plain mean of the four groups. The printed averages 10.8 and 8.7 do not follow "
        "from the printed rows, which give 10.7 and 8.6.",
        kOneFrameNote, interval_note(summary)};
    add_coverage_note(summary, condition, "mean", table);
    if (summary.simulated)
      table.notes.push_back(
          "Our numbers come from simulated sensors with declared errors, not from the paper's "
          "recordings: compare the ordering, not the size.");
    add_take_notes(summary, table);
    tables.push_back(std::move(table));
  }
  return tables;
}

}  // namespace trilat
