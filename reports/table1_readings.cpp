// SPDX-License-Identifier: MIT
#include "reports/table1_readings.h"

#include <cmath>
#include <map>

#include <fmt/format.h>

#include "datasets/base/units.h"

namespace trilat {
namespace {

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
