// SPDX-License-Identifier: MIT
#include "reports/efficiency.h"

#include <cmath>

#include "reports/accuracy_words.h"
#include "reports/table_cells.h"

namespace trilat {
namespace {

constexpr const char* kUnaligned = "none";

void add_rows(const ResultsSummary& s, const RangeRow& range, Table& table) {
  for (const std::string& method : s.methods) {
    const SummaryCell* cell = find_cell(s, method, range.condition, range.group, kUnaligned);
    if (!cell || !std::isfinite(cell->rms_gdop)) continue;
    const double bound_m = range.rms_error_m * cell->rms_gdop;
    table.rows.push_back({TableValue::of(range.group), TableValue::of(method), cm_cell(range.rms_error_m),
                          cm_cell(range.mean_error_m), TableValue::of(cell->rms_gdop, 2), cm_cell(bound_m),
                          cm_cell(cell->gdop_rmse_m),
                          TableValue::of(std::pow(bound_m / cell->gdop_rmse_m, 2), 2)});
  }
}

}  // namespace

std::vector<Table> efficiency_tables(const ResultsSummary& s, const TrackingSummary& tracking) {
  std::vector<Table> tables;
  for (const std::string& condition : s.conditions) {
    Table table;
    table.id = usable_id("efficiency-" + condition);
    table.title = "Efficiency against the bound (" + about(s, condition, kUnaligned) + ")";
    table.columns = {{"joint", "joint", true},
                     {"method", "method", true},
                     {"range RMS error (cm)", "range_rms_cm"},
                     {"of it mean (cm)", "range_mean_cm"},
                     {"rms GDOP", "rms_gdop"},
                     {"bound (cm)", "bound_cm"},
                     {"RMSE (cm)", "rmse_cm"},
                     {"efficiency", "efficiency"}};
    for (const RangeRow& range : tracking.ranges)
      if (range.condition == condition) add_rows(s, range, table);
    if (table.rows.empty()) continue;
    table.notes = {
        "Bound: the root mean square error of the ranges times the root mean square GDOP of the geometry, "
        "the "
        "Cramér-Rao bound of unbiased estimates from ranges whose errors are independent, normal and without "
        "a "
        "mean. GDOP and RMSE are of the same samples: those answered where the GDOP is finite. The ranges "
        "are those "
        "of all sensors, also for a method that uses some.",
        "Efficiency: the square of bound over RMSE. Trackers' errors are not independent: those of opposite "
        "sensors "
        "are anticorrelated along the line between them, which lets a method pass 1; so does answering only "
        "samples "
        "with small errors."};
    tables.push_back(std::move(table));
  }
  return tables;
}

}  // namespace trilat
