// SPDX-License-Identifier: MIT
#include <string>
#include <vector>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "pipeline/accuracy/shown/accuracy_shown.h"

namespace trilat {
namespace {

constexpr double kMillisecondsPerSecond = 1e3;

std::string data_text(const TrackingSummary& s) {
  return fmt::format("{}, {} sensors", s.study, s.simulated ? "simulated" : "recorded");
}

struct ShownUnit {
  double factor;  // from SI
  const char* name;
  int decimals;
};
ShownUnit shown_unit(const std::string& unit) {
  if (unit == "m") return {kCentimetresPerMetre, "cm", 2};
  if (unit == "rad") return {kDegreesPerRad, "degrees", 2};
  return {1.0, unit == "1" ? "ratio" : "s", 3};
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
  if (!s.clocks.empty()) tables.push_back(clocks_table(s));
  if (!s.rays.empty()) tables.push_back(rays_table(s));
  return tables;
}

std::string ray_text(const RayRow& row) {
  if (!row.problem.empty()) return fmt::format("along/across the rays: not known, {}", row.problem);
  return fmt::format(
      "sensors disagree by {:.1f} cm along their rays and {:.1f} cm across, ratio {:.2f} ({:.2f} to {:.2f})",
      row.range_m * kCentimetresPerMetre, row.bearing_m * kCentimetresPerMetre, row.ratio, row.ratio_low,
      row.ratio_high);
}

Table checks_table(const TrackingSummary& s) {
  Table table{"checks",
              fmt::format("What each take was checked by ({})", data_text(s)),
              {{"take", "take", true},
               {"sensor or joint", "subject", true},
               {"check", "what", true},
               {"value", "value", false, true},
               {"limit", "limit"},
               {"unit", "unit", true},
               {"beyond", "beyond", true}},
              {},
              {}};
  for (const CheckRow& row : s.checks) {
    const ShownUnit unit = shown_unit(row.unit);
    table.rows.push_back(
        {TableValue::of(row.take), TableValue::of(row.subject), TableValue::of(row.what),
         number_cell(unit.decimals, unit.factor * row.value, unit.factor * row.low, unit.factor * row.high),
         TableValue::of(unit.factor * row.limit, unit.decimals), TableValue::of(std::string(unit.name)),
         TableValue::of(std::string(row.beyond ? "yes" : "no"))});
  }
  add_notes(table, "checks");
  return table;
}

std::vector<std::string> pose_lines(const std::vector<CheckRow>& checks) {
  std::vector<std::string> lines;
  std::string sensor;
  for (const CheckRow& row : checks) {
    if (row.what != "turned" && row.what != "shifted" && row.what != "ranges too long") continue;
    const ShownUnit unit = shown_unit(row.unit);
    if (row.subject != sensor) lines.push_back(row.subject + ", beside its calibration:");
    lines.back() +=
        fmt::format("{} {} by {:.1f} ({:.1f} to {:.1f}) {}", row.subject == sensor ? "," : "", row.what,
                    unit.factor * row.value, unit.factor * row.low, unit.factor * row.high, unit.name);
    sensor = row.subject;
  }
  return lines;
}

}  // namespace trilat
