// SPDX-License-Identifier: MIT
#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "reports/tables/accuracy_words.h"
#include "reports/tables/tables.h"

namespace trilat {
namespace {

constexpr std::size_t kMostReadingsInFull = 12;
constexpr double kNormal95 = 1.96;

TableValue cm(double metres, int decimals = 2) {
  return TableValue::of(metres * kCentimetresPerMetre, decimals);
}
TableValue count(std::uint64_t n) { return TableValue::of(static_cast<double>(n), 0); }

std::string range_text(const SweepSummary::ErrorRange& range) {
  return fmt::format("{:g}-{:g}", range.low_m * kCentimetresPerMetre, range.high_m * kCentimetresPerMetre);
}

// The readings worth a table of their own.
std::vector<std::size_t> readings_in_full(const SweepSummary& s) {
  std::vector<std::size_t> all;
  std::set<std::size_t> leaders;
  for (std::size_t i = 0; i < s.interpretations.size(); ++i) all.push_back(i);
  if (all.size() <= kMostReadingsInFull || !s.search) return all;
  for (const SweepRanking* ranking : {&s.search->errors, &s.search->times})
    if (!ranking->best.empty()) leaders.insert(ranking->best.front().interpretation);
  for (const SweepCompromise& c : s.search->compromises) leaders.insert({c.printed, c.corrected});
  return {leaders.begin(), leaders.end()};
}

Table empty_sweep_table(const SweepSummary& s, std::size_t reading) {
  Table table;
  table.id = usable_id(fmt::format("sweep-{}-{}", s.study, s.interpretations[reading].id));
  table.title = fmt::format("Threshold sweep, simulated: {}; {} trials a cell, seed {}",
                            s.interpretations[reading].id, s.trials, s.seed);
  table.columns = {{"error range (cm)", "range_cm", true},
                   {"C (" + s.interpretations[reading].threshold_unit + ")", "threshold", false, true},
                   {"n", "n", false},
                   {"coverage (%)", "coverage_percent", false},
                   {"mean error (cm)", "mae_cm", false},
                   {"+- (cm)", "mae_half_interval_cm", false},
                   {"axis mean (cm)", "axis_mean_mae_cm", false},
                   {"RMSE (cm)", "rmse_cm", false},
                   {"p95 (cm)", "p95_cm", false},
                   {"max (cm)", "max_cm", false},
                   {"start (cm)", "start_mae_cm", false},
                   {"iterations", "iterations", false},
                   {"p50", "iterations_p50", false},
                   {"p99", "iterations_p99", false},
                   {"max", "iterations_max", false},
                   {"digits", "digits_mean", false},
                   {"digits min", "digits_min", false},
                   {"one (us)", "scalar_us", false},
                   {"batched (us)", "batched_us", false},
                   {"statuses", "statuses", true}};
  table.notes = {
      "Errors are distances to the true joint; +- is 1.96 standard errors of the mean; the axis mean is the "
      "mean of the three axes' mean absolute errors.",
      "Digits of agreement with the minimum of F, -log10 of the relative difference, at most 15. Times are "
      "of this machine, start included: one problem at a time, and many side by side by solve_nonlinear; the "
      "sweep itself, with one rig for all, is faster. Iterations are of all trials, also of those that "
      "failed."};
  return table;
}

}  // namespace

const SweepCellTiming* timing_of(const std::optional<SweepTimings>& timings, const SweepCell& cell) {
  if (!timings) return nullptr;
  for (const SweepCellTiming& t : timings->cells)
    if (t.interpretation == cell.interpretation && t.threshold == cell.threshold && t.range == cell.range)
      return &t;
  return nullptr;
}

std::vector<Table> sweep_tables(const SweepSummary& s, const std::optional<SweepTimings>& timings) {
  std::vector<Table> tables;
  for (const std::size_t reading : readings_in_full(s)) {
    Table table = empty_sweep_table(s, reading);
    for (std::size_t r = 0; r < s.ranges.size(); ++r)
      for (std::size_t t = 0; t < s.thresholds.size(); ++t) {
        const SweepCell& c = s.cell(reading, t, r);
        const SweepCellTiming* time = timing_of(timings, c);
        const double share = c.asked == 0
                                 ? SweepCell::kNone
                                 : 100.0 * static_cast<double>(c.answered) / static_cast<double>(c.asked);
        table.rows.push_back(
            {TableValue::of(range_text(s.ranges[r])),
             TableValue::of(s.thresholds[t], -1),
             count(c.answered),
             TableValue::of(share, 1),
             cm(c.mae_m),
             cm(kNormal95 * c.mae_standard_error_m, 3),
             cm(c.axis_mean_mae_m()),
             cm(c.rmse_m),
             cm(c.p95_m),
             cm(c.max_m),
             cm(c.start_mae_m),
             TableValue::of(c.mean_iterations, 2),
             TableValue::of(c.p50_iterations, 0),
             TableValue::of(c.p99_iterations, 0),
             TableValue::of(c.max_iterations, 0),
             TableValue::of(c.mean_digits, 1),
             TableValue::of(c.min_digits, 1),
             TableValue::of(time ? time->scalar_median_ns / kNsPerMicrosecond : SweepCell::kNone, 3),
             TableValue::of(time ? time->batched_median_ns / kNsPerMicrosecond : SweepCell::kNone, 3),
             TableValue::of(statuses_text(c.statuses, c.asked))});
      }
    tables.push_back(std::move(table));
  }
  return tables;
}

}  // namespace trilat
