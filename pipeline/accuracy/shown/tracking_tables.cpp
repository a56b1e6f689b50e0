// SPDX-License-Identifier: MIT
#include <algorithm>
#include <functional>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "pipeline/accuracy/shown/accuracy_shown.h"

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
  }
  return sums;
}

Table views_table(const TrackingSummary& s, const std::string& by,
                  const std::function<std::string(const ViewRow&)>& name) {
  using R = ViewRow;
  Table table = table_of<R>(usable_id("views-" + by),
                            fmt::format("Which views are rejected, by {} ({})", by, data_text(s)),
                            sum_views(s.views, name),
                            {{"condition", "condition", as_text(&R::condition)},
                             {by, by, as_text(name)},
                             {"rule", "rule", as_text(&R::rule)},
                             {"views", "views", as_count(&R::views)},
                             {"rejected (%)", "rejected_percent",
                              in_percent([](const R& r) { return share_of(r.rejected, r.views); })}});
  add_notes(table, "views");
  return table;
}

Table exchanges_table(const TrackingSummary& s) {
  using R = ExchangeRow;
  Table table = table_of<R>(
      "exchanges",
      fmt::format("Left and right exchanged by a sensor ({}); exchanges that were found were {}",
                  data_text(s), s.repaired ? "undone" : "left as they were"),
      s.exchanges,
      {{"condition", "condition", as_text(&R::condition)},
       {"sensor", "sensor", as_text(&R::sensor)},
       {"instants", "instants", as_count(&R::instants)},
       {"found (%)", "found_percent", in_percent([](const R& r) { return share_of(r.found, r.instants); })},
       {"stretches found", "stretches", as_count(&R::stretches)}});
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

}  // namespace trilat
