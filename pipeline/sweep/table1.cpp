// SPDX-License-Identifier: MIT
#include <array>
#include <cmath>
#include <functional>
#include <map>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "datasets/paper/printed_tables.h"
#include "pipeline/sweep/sweep_tables.h"

namespace trilat {
namespace {

// A row: a threshold in a range of errors.
struct Place {
  std::size_t threshold = 0, range = 0;
};

Table table_of_interpretations(const SweepSummary& s, const SweepTimings& timings, const PrintedTable1& paper,
                               const Table1Interpretations& interpretations) {
  std::vector<Place> rows;
  for (std::size_t r = 0; r < s.ranges; ++r)
    for (std::size_t t = 0; t < s.thresholds; ++t) rows.push_back({t, r});
  using Chosen = std::optional<std::size_t>;
  const Chosen both = interpretations.as_printed, e7 = interpretations.printed,
               ours = interpretations.corrected;
  // NaN without this interpretation.
  const auto of_cell = [&s](Chosen interpretation, auto get) {
    return [=, &s](const Place& p) {
      return interpretation ? get(s.number_of(*interpretation, p.threshold, p.range)) : kNaN;
    };
  };
  const auto number = [&](Chosen interpretation, const NumberKey& what) {
    return of_cell(interpretation, [&s, what](std::size_t cell) { return s.value(s.cells[cell], what); });
  };
  const auto error = [&](Chosen interpretation) { return in_cm(number(interpretation, kSweptError)); };
  const auto time = [&](Chosen interpretation) {
    return as_number(2, of_cell(interpretation, [&](std::size_t cell) {
                       return timings.problems > 0 ? timings.solve_us.at(cell) : kNaN;
                     }));
  };
  const auto steps = [&](Chosen interpretation) { return as_number(1, number(interpretation, kSweptSteps)); };
  const auto answered = [&](Chosen interpretation) {
    return in_percent(number(interpretation, kSweptAnswers));
  };
  const auto paper_time = [&](const Place& p) {
    const PrintedTable1::Row& row = paper.rows[p.threshold];
    return row.time_is_below ? TableValue::of(fmt::format("<{:g}", row.time_us[p.range]))
                             : TableValue::of(row.time_us[p.range], -1);
  };
  Table table = table_of<Place>(
      file_name_from("table1-" + s.cell(*interpretations.printed, 0, 0).rig),
      {"Table I: propagation error, time and iterations, the paper's beside ours, simulated",
       fmt::format("{}; {} trials a cell, seed {}", interpretations.name, s.trials, s.seed)},
      rows,
      {{"range (cm)", "range_cm", as_text([&](const Place& p) {
          return fmt::format("{:g}-{:g}", paper.ranges_cm[p.range][0], paper.ranges_cm[p.range][1]);
        })},
       {"C", "threshold", as_number(-1, [&](const Place& p) { return paper.rows[p.threshold].threshold; })},
       {"error, paper (cm)", "paper_error_cm",
        as_number(1, [&](const Place& p) { return paper.rows[p.threshold].error_cm[p.range]; })},
       {"E7+E8 (cm)", "as_printed_error_cm", error(both)},
       {"E7 (cm)", "printed_error_cm", error(e7)},
       {"corrected (cm)", "corrected_error_cm", error(ours)},
       {"time, paper (us)", "paper_time_us", CellOf{paper_time}},
       {"E7+E8 (us)", "as_printed_time_us", time(both)},
       {"E7 (us)", "printed_time_us", time(e7)},
       {"corrected (us)", "corrected_time_us", time(ours)},
       {"steps, E7+E8", "as_printed_iterations", steps(both)},
       {"E7", "printed_iterations", steps(e7)},
       {"corrected", "corrected_iterations", steps(ours)},
       {"answered, E7 (%)", "printed_answered_percent", answered(e7)},
       {"corrected (%)", "corrected_answered_percent", answered(ours)}});
  table.printed = "table1";
  add_notes(table, "table1");
  return table;
}

constexpr std::size_t kMaxTables = 6;
constexpr double kSameNumber = 1e-9;  // relative

std::string family_name(const SweepSetting& s) {
  return fmt::format("{}, joint {}, error {}, C in {}, start {}, damping {}, {}", s.rig, s.joint,
                     s.error_model, s.threshold_unit, s.start, s.damping, s.curvature);
}

std::map<std::string, Table1Interpretations> interpretations_by_name(const SweepSummary& s) {
  std::map<std::string, Table1Interpretations> all;
  for (std::size_t k = 0; k < s.interpretations(); ++k) {
    const SweepSetting& setting = s.cell(k, 0, 0);
    Table1Interpretations& interpretations = all[family_name(setting)];
    if (setting.gradient == "printed" && setting.stop == "printed") interpretations.as_printed = k;
    if (setting.gradient == "printed" && setting.stop == "objective") interpretations.printed = k;
    if (setting.gradient == "corrected" && setting.stop == "objective") interpretations.corrected = k;
  }
  return all;
}

bool same(double a, double b) { return std::abs(a - b) <= kSameNumber * std::abs(b); }

bool is_the_papers_grid(const SweepSummary& s, const PrintedTable1& paper) {
  if (s.thresholds != paper.rows.size() || s.ranges != paper.ranges_cm.size()) return false;
  bool all = true;
  for (std::size_t t = 0; t < paper.rows.size(); ++t)
    for (std::size_t r = 0; r < paper.ranges_cm.size(); ++r) {
      const SweepSetting& setting = s.cell(0, t, r);
      all &= same(setting.threshold, paper.rows[t].threshold) &&
             same(setting.error_low_m * kCentimetresPerMetre, paper.ranges_cm[r][0]) &&
             same(setting.error_high_m * kCentimetresPerMetre, paper.ranges_cm[r][1]);
    }
  return all;
}

// Whether the last threshold but one is a compromise in an interpretation, at every error range: the last one
// takes twice its steps, and the first one errs by a tenth more.
bool is_compromise(const SweepSummary& s, std::size_t interpretation) {
  constexpr double kMoreSteps = 2.0, kLessAccurate = 1.1;
  const std::size_t last = s.thresholds - 1;
  for (std::size_t range = 0; range < s.ranges; ++range) {
    const SweepCell &first = s.cell(interpretation, 0, range),
                    &chosen = s.cell(interpretation, last - 1, range),
                    &smallest = s.cell(interpretation, last, range);
    if (!(s.value(smallest, kSweptSteps) >= kMoreSteps * s.value(chosen, kSweptSteps)) ||
        !(s.value(first, kSweptError) >= kLessAccurate * s.value(chosen, kSweptError)))
      return false;
  }
  return true;
}

// Whether every error is near the printed one, as the mean distance or as the mean over axes.
bool is_near(const SweepSummary& s, std::size_t interpretation, const PrintedTable1& paper) {
  constexpr double kNear = 2.0, kAnswered = 0.9;
  std::array<bool, 2> near{true, true};
  for (std::size_t range = 0; range < s.ranges; ++range)
    for (std::size_t t = 0; t < s.thresholds; ++t) {
      const SweepCell& cell = s.cell(interpretation, t, range);
      const double printed_m = paper.rows[t].error_cm[range] / kCentimetresPerMetre;
      const bool answers = s.value(cell, kSweptAnswers) >= kAnswered;
      const std::array<double, 2> error_m{s.value(cell, kSweptError), axis_mean_m(s, cell)};
      for (const std::size_t k : {0u, 1u})
        near[k] = near[k] && answers && error_m[k] <= kNear * printed_m && error_m[k] >= printed_m / kNear;
    }
  return near[0] || near[1];
}

}  // namespace

void add_interpretations(SweepSummary& s) {
  const PrintedTable1 paper = printed_table1();
  if (s.thresholds != paper.rows.size() || s.ranges != paper.ranges_cm.size() || s.thresholds < 3) return;
  std::uint64_t near = 0, compromise = 0;
  for (std::size_t k = 0; k < s.interpretations(); ++k) {
    if (!is_near(s, k, paper)) continue;
    ++near;
    compromise += is_compromise(s, k);
  }
  s.numbers.add({{.measure = "interpretations", .statistic = "share_near"},
                 share_of(near, s.interpretations()),
                 kNaN,
                 kNaN,
                 s.interpretations()});
  s.numbers.add(
      {{.measure = "interpretations", .statistic = "share"}, share_of(compromise, near), kNaN, kNaN, near});
}

std::vector<Table> table1(const SweepSummary& s, const SweepTimings& timings) {
  const PrintedTable1 paper = printed_table1();
  std::vector<Table> tables;
  for (const Table1Interpretations& interpretations : table1_interpretations(s, paper))
    tables.push_back(table_of_interpretations(s, timings, paper, interpretations));
  return tables;
}

std::vector<Table1Interpretations> table1_interpretations(const SweepSummary& s, const PrintedTable1& paper) {
  std::vector<Table1Interpretations> shown;
  if (!is_the_papers_grid(s, paper)) return shown;
  const std::map<std::string, Table1Interpretations> all = interpretations_by_name(s);
  if (all.size() > kMaxTables) return shown;
  for (const auto& [name, interpretations] : all)
    if (interpretations.complete()) {
      shown.push_back(interpretations);
      shown.back().name = name;
    }
  return shown;
}

}  // namespace trilat
