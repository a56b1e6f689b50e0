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

// Rows that have `name` in common are added up, in the order of their first.
std::vector<ViewRow> sum_views(const std::vector<ViewRow>& views,
                               const std::function<std::string(const ViewRow&)>& name) {
  std::vector<ViewRow> sums;
  for (const ViewRow& row : views) {
    auto sum = std::ranges::find_if(sums, [&](const ViewRow& other) {
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
  using R = ViewRow;
  const auto known = [](const R& r, std::uint64_t part, std::uint64_t whole) {
    return r.truth_known ? share_of(part, whole) : kNoNumber;
  };
  Table table = table_of<R>(usable_id("views-" + by),
                            fmt::format("Which views are rejected, by {} ({})", by, data_text(s)),
                            sum_views(s.views, name),
                            {{"condition", "condition", as_text(&R::condition)},
                             {by, by, as_text(name)},
                             {"rule", "rule", as_text(&R::rule)},
                             {"views", "views", as_count(&R::views)},
                             {"rejected (%)", "rejected_percent",
                              in_percent([](const R& r) { return share_of(r.rejected, r.views); })},
                             {"truly hidden (%)", "hidden_percent",
                              in_percent([=](const R& r) { return known(r, r.hidden, r.views); })},
                             {"rightly, of the rejected (%)", "rightly_percent",
                              in_percent([=](const R& r) { return known(r, r.rightly, r.rejected); })},
                             {"found, of the hidden (%)", "found_percent",
                              in_percent([=](const R& r) { return known(r, r.rightly, r.hidden); })}});
  add_notes(table, "views");
  return table;
}

Table exchanges_table(const TrackingSummary& s) {
  using R = ExchangeRow;
  const auto known = [](const R& r, double value) { return r.truth_known ? value : kNoNumber; };
  Table table = table_of<R>(
      "exchanges",
      fmt::format("Left and right exchanged by a sensor ({}); exchanges that were found were {}",
                  data_text(s), s.repaired ? "undone" : "left as they were"),
      s.exchanges,
      {{"condition", "condition", as_text(&R::condition)},
       {"sensor", "sensor", as_text(&R::sensor)},
       {"instants", "instants", as_count(&R::instants)},
       {"found (%)", "found_percent", in_percent([](const R& r) { return share_of(r.found, r.instants); })},
       {"stretches found", "stretches", as_count(&R::stretches)},
       {"truly exchanged (%)", "exchanged_percent",
        in_percent([=](const R& r) { return known(r, share_of(r.exchanged, r.instants)); })},
       {"true stretches", "true_stretches",
        as_count([=](const R& r) { return known(r, static_cast<double>(r.true_stretches)); })},
       {"of them found (%)", "stretches_found_percent",
        in_percent([=](const R& r) { return known(r, share_of(r.stretches_found, r.true_stretches)); })},
       {"right ones touched (%)", "touched_percent", in_percent([=](const R& r) {
          return known(r, share_of(r.found - r.rightly, r.instants - r.exchanged));
        })}});
  add_notes(table, "exchanges");
  return table;
}

Table clocks_table(const TrackingSummary& s) {
  using R = ClockRow;
  const auto ms = [](double R::*seconds) {
    return [=](const R& r) { return r.*seconds * kMillisecondsPerSecond; };
  };
  Table table = table_of<R>(
      "clocks",
      fmt::format("Offset between mocap and sensors by motion, the trackers' lag included ({})",
                  data_text(s)),
      s.clocks,
      {{"take", "take", as_text(&R::take)},
       {"offset (ms)", "offset_ms", as_number(2, ms(&R::offset_s), ms(&R::low_s), ms(&R::high_s))},
       {"drift (ppm)", "drift_ppm", as_number(0, &R::drift_ppm)},
       {"± (ppm)", "drift_sigma_ppm", as_number(0, &R::drift_sigma_ppm)},
       {"correlation", "peak", as_number(3, &R::peak)},
       {"next peak / first", "second", as_number(3, &R::second)},
       {"outcome", "outcome", as_text(&R::status)},
       {"applied", "applied", as_text([](const R& r) { return r.applied ? "yes" : "no"; })}});
  add_notes(table, "clocks");
  return table;
}

Table rays_table(const TrackingSummary& s) {
  using R = RayRow;
  Table table = table_of<R>(
      "rays", fmt::format("How sensors disagree along and across their rays ({})", data_text(s)), s.rays,
      {{"take", "take", as_text(&R::take)},
       {"along (cm)", "range_cm", in_cm(&R::range_m)},
       {"across (cm)", "bearing_cm", in_cm(&R::bearing_m)},
       {"along / across", "ratio", as_number(2, &R::ratio, &R::ratio_low, &R::ratio_high)},
       {"", "problem", as_text(&R::problem)}});
  add_notes(table, "rays");
  return table;
}

Table corrections_table(const TrackingSummary& s) {
  using R = CorrectionRow;
  Table table = table_of<R>(
      "corrections", fmt::format("How sensors stand and measure beside their calibration ({})", data_text(s)),
      s.corrections,
      {{"take", "take", as_text(&R::take)},
       {"sensor", "sensor", as_text(&R::sensor)},
       {"turned (degrees)", "turned_deg",
        as_number(1, kDegreesPerRad, &R::turned_rad, &R::turned_low_rad, &R::turned_high_rad)},
       {"stated (degrees)", "stated_turn_deg", as_number(1, kDegreesPerRad, &R::stated_turn_rad)},
       {"shifted (cm)", "shifted_cm", in_cm(&R::shifted_m, &R::shifted_low_m, &R::shifted_high_m)},
       {"stated (cm)", "stated_shift_cm", as_number(1, kCentimetresPerMetre, &R::stated_shift_m)},
       {"ranges too long (cm)", "too_long_cm",
        in_cm(&R::too_long_m, &R::too_long_low_m, &R::too_long_high_m)},
       {"", "problem", as_text(&R::problem)}});
  add_notes(table, "corrections");
  return table;
}

Table predictions_table(const TrackingSummary& s) {
  using R = PredictionRow;
  Table table = table_of<R>("predictions",
                            fmt::format("What a sensor sees, predicted from the others ({})", data_text(s)),
                            s.predictions,
                            {{"condition", "condition", as_text(&R::condition)},
                             {"method", "method", as_text(&R::method)},
                             {"along its ray (cm)", "range_cm", in_cm(&R::range_m)},
                             {"across (cm)", "bearing_cm", in_cm(&R::bearing_m)},
                             {"too far by (cm)", "mean_range_cm", in_cm(&R::mean_range_m)},
                             {"bones vary by (cm)", "bone_cm", in_cm(&R::bone_m)},
                             {"jerk (m/s³)", "jerk_m_s3", as_number(0, &R::jerk_m_s3)},
                             {"n", "n", as_count(&R::n)}});
  add_notes(table, "predictions");
  return table;
}

constexpr const char* kUnaligned = "none";

// A method's errors where its ranges have this error, and what they can be at best.
struct Efficiency {
  RangeRow range;
  const SummaryCell* cell;
  double bound_m() const { return range.rms_error_m * cell->rms_gdop; }
  double share() const { return std::pow(bound_m() / cell->gdop_rmse_m, 2); }
};

std::vector<Efficiency> efficiencies(const ResultsSummary& s, const TrackingSummary& tracking,
                                     const std::string& condition) {
  std::vector<Efficiency> rows;
  for (const RangeRow& range : tracking.ranges)
    for (const std::string& method : s.methods)
      if (const SummaryCell* cell = find_cell(s, method, condition, range.group, kUnaligned);
          range.condition == condition && cell && std::isfinite(cell->rms_gdop))
        rows.push_back({range, cell});
  return rows;
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
    using R = Efficiency;
    const auto cell = [](const R& r) { return *r.cell; };
    Table table = table_of<R>(
        usable_id("efficiency-" + condition),
        "Efficiency against the bound (" + about(s, condition, kUnaligned) + ")",
        efficiencies(s, tracking, condition),
        {{"joint", "joint", of(&R::range, as_text(&RangeRow::group))},
         {"method", "method", of(cell, as_text(&SummaryCell::method))},
         {"range RMS error (cm)", "range_rms_cm", of(&R::range, in_cm(&RangeRow::rms_error_m))},
         {"mean range error (cm)", "range_mean_cm", of(&R::range, in_cm(&RangeRow::mean_error_m))},
         {"rms GDOP", "rms_gdop", of(cell, as_number(2, &SummaryCell::rms_gdop))},
         {"bound (cm)", "bound_cm", in_cm(&R::bound_m)},
         {"RMSE (cm)", "rmse_cm", of(cell, in_cm(&SummaryCell::gdop_rmse_m))},
         {"efficiency", "efficiency", as_number(2, &R::share)}});
    if (table.rows.empty()) continue;
    add_notes(table, "efficiency");
    tables.push_back(std::move(table));
  }
  return tables;
}

}  // namespace trilat
