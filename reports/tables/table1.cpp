// SPDX-License-Identifier: MIT
#include "reports/tables/table1.h"

#include <cmath>
#include <map>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "datasets/paper/printed_tables.h"
#include "reports/tables/tables.h"

namespace trilat {
namespace {

class TableColumn {
 public:
  TableColumn(const SweepSummary& s, const std::optional<SweepTimings>& timings,
              std::optional<std::size_t> reading)
      : s_(s), timings_(timings), reading_(reading) {}

  TableValue error_cm(std::size_t t, std::size_t r, bool axis_mean) const {
    return number(
        t, r,
        [&](const SweepCell& c) {
          return kCentimetresPerMetre * (axis_mean ? c.axis_mean_mae_m() : c.mae_m);
        },
        2);
  }
  TableValue iterations(std::size_t t, std::size_t r) const {
    return number(
        t, r, [](const SweepCell& c) { return c.mean_iterations; }, 1);
  }
  // NaN without this reading.
  double answered_percent(std::size_t t, std::size_t r) const {
    if (!reading_ || s_.cell(*reading_, t, r).asked == 0) return SweepCell::kNone;
    const SweepCell& c = s_.cell(*reading_, t, r);
    return 100.0 * static_cast<double>(c.answered) / static_cast<double>(c.asked);
  }
  TableValue time_us(std::size_t t, std::size_t r) const {
    const SweepCellTiming* time = reading_ ? timing_of(timings_, s_.cell(*reading_, t, r)) : nullptr;
    return TableValue::of(time ? time->scalar_median_ns / kNsPerMicrosecond : SweepCell::kNone, 2);
  }

 private:
  template <class Get>
  TableValue number(std::size_t t, std::size_t r, const Get& get, int decimals) const {
    return TableValue::of(reading_ ? get(s_.cell(*reading_, t, r)) : SweepCell::kNone, decimals);
  }

  const SweepSummary& s_;
  const std::optional<SweepTimings>& timings_;
  std::optional<std::size_t> reading_;
};

void add_rows(Table& table, const SweepSummary& s, const std::optional<SweepTimings>& timings,
              const PrintedTable1& paper, const Table1Readings& readings) {
  const bool axis_mean = readings.axis_mean;
  const TableColumn as_printed(s, timings, readings.as_printed), printed(s, timings, readings.printed),
      corrected(s, timings, readings.corrected);
  for (std::size_t r = 0; r < s.ranges.size(); ++r)
    for (std::size_t t = 0; t < s.thresholds.size(); ++t) {
      const PrintedTable1::Row& row = paper.rows[t];
      TableValue time = TableValue::of(row.time_us[r], -1);
      if (row.time_is_below) time = TableValue::of(fmt::format("<{:g}", row.time_us[r]));
      table.rows.push_back(
          {TableValue::of(fmt::format("{:g}-{:g}", paper.ranges_cm[r][0], paper.ranges_cm[r][1])),
           TableValue::of(row.threshold, -1), TableValue::of(row.error_cm[r], 1),
           as_printed.error_cm(t, r, axis_mean), printed.error_cm(t, r, axis_mean),
           corrected.error_cm(t, r, axis_mean), time, as_printed.time_us(t, r), printed.time_us(t, r),
           corrected.time_us(t, r), as_printed.iterations(t, r), printed.iterations(t, r),
           corrected.iterations(t, r), TableValue::of(printed.answered_percent(t, r), 1),
           TableValue::of(corrected.answered_percent(t, r), 1)});
    }
}

Table empty_table1(const SweepSummary& s, const Table1Readings& readings) {
  Table table;
  table.id = usable_id("table1-" + s.interpretations[*readings.printed].rig);
  table.title = fmt::format(
      "Table I: propagation error, time and iterations, the paper's beside ours, simulated ({}; {} trials a "
      "cell, seed {})",
      readings.name, s.trials, s.seed);
  table.columns = {{"range (cm)", "range_cm", true},
                   {"C", "threshold", false, true},
                   {"error, paper (cm)", "paper_error_cm", false},
                   {"E7+E8 (cm)", "as_printed_error_cm", false},
                   {"E7 (cm)", "printed_error_cm", false},
                   {"corrected (cm)", "corrected_error_cm", false},
                   {"time, paper (us)", "paper_time_us", false},
                   {"E7+E8 (us)", "as_printed_time_us", false},
                   {"E7 (us)", "printed_time_us", false},
                   {"corrected (us)", "corrected_time_us", false},
                   {"steps, E7+E8", "as_printed_iterations", false},
                   {"E7", "printed_iterations", false},
                   {"corrected", "corrected_iterations", false},
                   {"answered, E7 (%)", "printed_answered_percent", false},
                   {"corrected (%)", "corrected_answered_percent", false}};
  add_notes(table, "table1",
            {{"error", readings.axis_mean ? "mean over the three axes of the mean absolute error, which is "
                                            "the metric of the best-fitting reading"
                                          : "mean distance to the true joint"}});
  return table;
}

constexpr std::size_t kMostTables = 6;
constexpr double kSameNumber = 1e-9;  // relative

std::string family_name(const SweepInterpretation& i) {
  return fmt::format("{}, joint {}, error {}, C in {}, start {}, damping {}, {}", i.rig, i.joint,
                     i.error_model, i.threshold_unit, i.start, i.damping, i.curvature);
}

bool reports_axis_mean(const SweepSummary& s, std::size_t reading) {
  if (!s.search || s.search->errors.best.empty()) return false;
  const SweepFit& best = s.search->errors.best.front();
  return best.interpretation == reading && best.reported == "axis_mean";
}

std::map<std::string, Table1Readings> readings_by_name(const SweepSummary& s) {
  std::map<std::string, Table1Readings> all;
  for (std::size_t k = 0; k < s.interpretations.size(); ++k) {
    const SweepInterpretation& i = s.interpretations[k];
    Table1Readings& readings = all[family_name(i)];
    readings.axis_mean |= reports_axis_mean(s, k);
    if (i.gradient == "printed" && i.stop == "printed") readings.as_printed = k;
    if (i.gradient == "printed" && i.stop == "objective") readings.printed = k;
    if (i.gradient == "corrected" && i.stop == "objective") readings.corrected = k;
  }
  return all;
}

// Of many, those that a ranking or a comparison names.
bool is_worth_a_table(const SweepSummary& s, const Table1Readings& readings, std::size_t families) {
  if (!readings.complete()) return false;
  if (families <= kMostTables) return true;
  if (!s.search) return false;
  for (const SweepCompromise& c : s.search->compromises)
    if (c.printed == *readings.printed || c.corrected == *readings.corrected) return true;
  return false;
}

bool same(double a, double b) { return std::abs(a - b) <= kSameNumber * std::abs(b); }

bool is_the_papers_grid(const SweepSummary& s, const PrintedTable1& paper) {
  if (s.thresholds.size() != paper.rows.size() || s.ranges.size() != paper.ranges_cm.size()) return false;
  bool all = true;
  for (std::size_t t = 0; t < paper.rows.size(); ++t) all &= same(s.thresholds[t], paper.rows[t].threshold);
  for (std::size_t r = 0; r < paper.ranges_cm.size(); ++r)
    all &= same(s.ranges[r].low_m * kCentimetresPerMetre, paper.ranges_cm[r][0]) &&
           same(s.ranges[r].high_m * kCentimetresPerMetre, paper.ranges_cm[r][1]);
  return all;
}

}  // namespace

std::vector<Table> table1(const SweepSummary& s, const std::optional<SweepTimings>& timings) {
  const PrintedTable1 paper = printed_table1();
  std::vector<Table> tables;
  for (const Table1Readings& readings : table1_readings(s, paper)) {
    Table table = empty_table1(s, readings);
    add_rows(table, s, timings, paper, readings);
    tables.push_back(std::move(table));
  }
  return tables;
}

std::vector<Table1Readings> table1_readings(const SweepSummary& s, const PrintedTable1& paper) {
  std::vector<Table1Readings> shown;
  if (!is_the_papers_grid(s, paper)) return shown;
  const std::map<std::string, Table1Readings> all = readings_by_name(s);
  for (const auto& [name, readings] : all)
    if (is_worth_a_table(s, readings, all.size())) {
      shown.push_back(readings);
      shown.back().name = name;
    }
  return shown;
}

}  // namespace trilat
