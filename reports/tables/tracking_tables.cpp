// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <functional>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "reports/tables/accuracy_words.h"
#include "reports/tables/table.h"
#include "reports/tables/tables.h"

namespace trilat {

namespace {

constexpr double kMillisecondsPerSecond = 1e3;

std::string data_text(const TrackingSummary& s) {
  return fmt::format("{}, {} sensors", s.study, s.simulated ? "simulated" : "recorded");
}

TableValue known(bool truth_known, double share) { return truth_known ? percent_cell(share) : no_cell(); }

// Rows that have `name` in common are added up, in the order of their first.
std::vector<ViewRow> sum_views(const std::vector<ViewRow>& views,
                               const std::function<std::string(const ViewRow&)>& name) {
  std::vector<ViewRow> sums;
  for (const ViewRow& row : views) {
    auto sum = std::find_if(sums.begin(), sums.end(), [&](const ViewRow& other) {
      return other.condition == row.condition && other.rule == row.rule && name(other) == name(row);
    });
    if (sum == sums.end()) {
      sums.push_back(row);
      continue;
    }
    sum->views += row.views;
    sum->rejected += row.rejected;
    sum->truth_known = sum->truth_known && row.truth_known;
    sum->hidden += row.hidden;
    sum->rightly += row.rightly;
  }
  return sums;
}

Table views_table(const TrackingSummary& s, const std::string& by,
                  const std::function<std::string(const ViewRow&)>& name) {
  Table table;
  table.id = usable_id("views-" + by);
  table.title = fmt::format("Which views are rejected, by {} ({})", by, data_text(s));
  table.columns = {{"condition", "condition", true},
                   {by, by, true},
                   {"rule", "rule", true},
                   {"views", "views"},
                   {"rejected (%)", "rejected_percent"},
                   {"truly hidden (%)", "hidden_percent"},
                   {"rightly, of the rejected (%)", "rightly_percent"},
                   {"found, of the hidden (%)", "found_percent"}};
  for (const ViewRow& row : sum_views(s.views, name))
    table.rows.push_back({TableValue::of(row.condition), TableValue::of(name(row)), TableValue::of(row.rule),
                          count_cell(row.views), percent_cell(share_of(row.rejected, row.views)),
                          known(row.truth_known, share_of(row.hidden, row.views)),
                          known(row.truth_known, share_of(row.rightly, row.rejected)),
                          known(row.truth_known, share_of(row.rightly, row.hidden))});
  table.notes = notes("views");
  return table;
}

Table exchanges_table(const TrackingSummary& s) {
  Table table;
  table.id = "exchanges";
  table.title = fmt::format("Left and right exchanged by a sensor ({}); exchanges that were found were {}",
                            data_text(s), s.repaired ? "undone" : "left as they were");
  table.columns = {{"condition", "condition", true},
                   {"sensor", "sensor", true},
                   {"instants", "instants"},
                   {"found (%)", "found_percent"},
                   {"stretches found", "stretches"},
                   {"truly exchanged (%)", "exchanged_percent"},
                   {"true stretches", "true_stretches"},
                   {"of them found (%)", "stretches_found_percent"},
                   {"right ones touched (%)", "touched_percent"}};
  for (const ExchangeRow& row : s.exchanges)
    table.rows.push_back(
        {TableValue::of(row.condition), TableValue::of(row.sensor), count_cell(row.instants),
         percent_cell(share_of(row.found, row.instants)), count_cell(row.stretches),
         known(row.truth_known, share_of(row.exchanged, row.instants)),
         row.truth_known ? count_cell(row.true_stretches) : no_cell(),
         known(row.truth_known, share_of(row.stretches_found, row.true_stretches)),
         known(row.truth_known, share_of(row.found - row.rightly, row.instants - row.exchanged))});
  table.notes = notes("exchanges");
  return table;
}

Table clocks_table(const TrackingSummary& s) {
  const auto ms = [](double seconds) { return seconds * kMillisecondsPerSecond; };
  Table table;
  table.id = "clocks";
  table.title = fmt::format("Offset between mocap and sensors by motion, the trackers' lag included ({})",
                            data_text(s));
  table.columns = {{"take", "take", true},       interval_column("offset (ms)", "offset_ms"),
                   {"drift (ppm)", "drift_ppm"}, {"± (ppm)", "drift_sigma_ppm"},
                   {"correlation", "peak"},      {"next peak / first", "second"},
                   {"outcome", "outcome", true}, {"applied", "applied", true}};
  for (const ClockRow& row : s.clocks)
    table.rows.push_back(
        {TableValue::of(row.take), number_cell(2, ms(row.offset_s), ms(row.low_s), ms(row.high_s)),
         TableValue::of(row.drift_ppm, 0), TableValue::of(row.drift_sigma_ppm, 0),
         TableValue::of(row.peak, 3), TableValue::of(row.second, 3), TableValue::of(row.status),
         TableValue::of(std::string(row.applied ? "yes" : "no"))});
  table.notes = notes("clocks");
  return table;
}

Table rays_table(const TrackingSummary& s) {
  Table table;
  table.id = "rays";
  table.title = fmt::format("How sensors disagree along and across their rays ({})", data_text(s));
  table.columns = {{"take", "take", true},
                   {"along (cm)", "range_cm"},
                   {"across (cm)", "bearing_cm"},
                   interval_column("along / across", "ratio"),
                   {"", "problem", true}};
  for (const RayRow& row : s.rays)
    table.rows.push_back({TableValue::of(row.take), cm_cell(row.range_m), cm_cell(row.bearing_m),
                          number_cell(2, row.ratio, row.ratio_low, row.ratio_high),
                          TableValue::of(row.problem)});
  table.notes = notes("rays");
  return table;
}

Table corrections_table(const TrackingSummary& s) {
  const auto degrees = [](double rad) { return rad / kRadPerDegree; };
  Table table;
  table.id = "corrections";
  table.title = fmt::format("How sensors stand and measure beside their calibration ({})", data_text(s));
  table.columns = {{"take", "take", true},
                   {"sensor", "sensor", true},
                   interval_column("turned (degrees)", "turned_deg"),
                   {"stated (degrees)", "stated_turn_deg"},
                   interval_column("shifted (cm)", "shifted_cm"),
                   {"stated (cm)", "stated_shift_cm"},
                   interval_column("ranges too long (cm)", "too_long_cm"),
                   {"", "problem", true}};
  for (const CorrectionRow& row : s.corrections)
    table.rows.push_back(
        {TableValue::of(row.take), TableValue::of(row.sensor),
         number_cell(1, degrees(row.turned_rad), degrees(row.turned_low_rad), degrees(row.turned_high_rad)),
         TableValue::of(degrees(row.stated_turn_rad), 1),
         cm_cell(row.shifted_m, row.shifted_low_m, row.shifted_high_m),
         TableValue::of(row.stated_shift_m * kCentimetresPerMetre, 1),
         cm_cell(row.too_long_m, row.too_long_low_m, row.too_long_high_m), TableValue::of(row.problem)});
  table.notes = notes("corrections");
  return table;
}

Table predictions_table(const TrackingSummary& s) {
  Table table;
  table.id = "predictions";
  table.title = fmt::format("What a sensor sees, predicted from the others ({})", data_text(s));
  table.columns = {{"condition", "condition", true},
                   {"method", "method", true},
                   interval_column("along its ray (cm)", "range_cm"),
                   interval_column("across (cm)", "bearing_cm"),
                   interval_column("too far by (cm)", "mean_range_cm"),
                   interval_column("bones vary by (cm)", "bone_cm"),
                   interval_column("jerk (m/s³)", "jerk_m_s3"),
                   {"n", "n"}};
  const auto centimetres = [](const Estimate& e) { return cm_cell(e.value, e.low, e.high); };
  for (const PredictionRow& row : s.predictions)
    table.rows.push_back({TableValue::of(row.condition), TableValue::of(row.method), centimetres(row.range_m),
                          centimetres(row.bearing_m), centimetres(row.mean_range_m), centimetres(row.bone_m),
                          number_cell(0, row.jerk_m_s3.value, row.jerk_m_s3.low, row.jerk_m_s3.high),
                          count_cell(row.n)});
  table.notes = notes("predictions");
  return table;
}

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

std::vector<Table> prediction_tables(const TrackingSummary& s) {
  if (s.predictions.empty()) return {};
  return {predictions_table(s)};
}

std::vector<Table> tracking_tables(const TrackingSummary& s) {
  std::vector<Table> tables;
  if (!s.views.empty()) {
    tables.push_back(views_table(s, "joint", [](const ViewRow& row) { return row.group; }));
    tables.push_back(views_table(s, "sensor", [](const ViewRow& row) { return row.sensor; }));
  }
  if (!s.exchanges.empty()) tables.push_back(exchanges_table(s));
  if (!s.clocks.empty()) tables.push_back(clocks_table(s));
  if (!s.rays.empty()) tables.push_back(rays_table(s));
  if (!s.corrections.empty()) tables.push_back(corrections_table(s));
  for (Table& table : prediction_tables(s)) tables.push_back(std::move(table));
  return tables;
}

std::string ray_text(const RayRow& row) {
  if (!row.problem.empty()) return fmt::format("along/across the rays: not known, {}", row.problem);
  return fmt::format(
      "sensors disagree by {:.1f} cm along their rays and {:.1f} cm across, ratio {:.2f} ({:.2f} to {:.2f})",
      row.range_m * kCentimetresPerMetre, row.bearing_m * kCentimetresPerMetre, row.ratio, row.ratio_low,
      row.ratio_high);
}

std::string correction_text(const CorrectionRow& row) {
  if (!row.problem.empty()) return fmt::format("{}: as calibrated, {}", row.sensor, row.problem);
  const auto text = [](double factor, double value, double low, double high) {
    return fmt::format("{:.1f} ({:.1f} to {:.1f})", factor * value, factor * low, factor * high);
  };
  return fmt::format(
      "{}: turned by {} degrees, shifted by {} cm, ranges too long by {} cm, beside its calibration",
      row.sensor, text(1.0 / kRadPerDegree, row.turned_rad, row.turned_low_rad, row.turned_high_rad),
      text(kCentimetresPerMetre, row.shifted_m, row.shifted_low_m, row.shifted_high_m),
      text(kCentimetresPerMetre, row.too_long_m, row.too_long_low_m, row.too_long_high_m));
}

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
    table.notes = notes("efficiency");
    tables.push_back(std::move(table));
  }
  return tables;
}

}  // namespace trilat
