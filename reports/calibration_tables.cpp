// SPDX-License-Identifier: MIT
#include "reports/calibration_tables.h"

#include <fmt/format.h>

#include "datasets/base/units.h"

namespace trilat {
namespace {

Table rigs_table(const CalibrationSummary& s) {
  Table table;
  table.id = "calibration_rigs";
  table.title =
      fmt::format("Poses of the sensors after calibration with {} wand positions (simulated)", s.positions);
  table.columns = {{"method", "method", true},          {"runs", "runs"},
                   {"failed", "failed_runs"},           {"position error (mm)", "position_mean_mm"},
                   {"largest (mm)", "position_max_mm"}, {"turned by (°)", "rotation_mean_deg"},
                   {"largest (°)", "rotation_max_deg"}, {"in 95 % interval (%)", "coverage_percent"}};
  for (const RigRow& r : s.rigs)
    table.rows.push_back(
        {TableValue::of(r.method), TableValue::of(static_cast<double>(r.runs), 0),
         TableValue::of(static_cast<double>(r.failed_runs), 0), TableValue::of(1e3 * r.position.mean_m, 2),
         TableValue::of(1e3 * r.position.max_m, 2), TableValue::of(r.rotation_mean_rad / kRadPerDegree, 3),
         TableValue::of(r.rotation_max_rad / kRadPerDegree, 3), TableValue::of(100.0 * r.coverage_share, 1)});
  return table;
}

}  // namespace

std::vector<Table> calibration_tables(const CalibrationSummary& summary) {
  std::vector<Table> tables;
  if (!summary.rigs.empty()) tables.push_back(rigs_table(summary));
  return tables;
}

}  // namespace trilat
