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
  using R = ClockOffsetRow;
  const auto ms = [](double R::*seconds) {
    return [=](const R& r) { return r.*seconds * kMillisecondsPerSecond; };
  };
  Table table = table_of<R>(
      "clocks", {"Offset between mocap and sensors by motion, the trackers' lag included", data_text(s)},
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
  using R = RayNoiseRow;
  Table table =
      table_of<R>("rays", {"How sensors disagree along and across their rays", data_text(s)}, s.rays,
                  {{"take", "take", as_text(&R::take)},
                   {"along (cm)", "range_cm", in_cm(&R::range_m)},
                   {"across (cm)", "bearing_cm", in_cm(&R::bearing_m)},
                   {"along / across", "ratio", as_number(2, &R::ratio, &R::ratio_low, &R::ratio_high)},
                   {"", "problem", as_text(&R::problem)}});
  add_notes(table, "rays");
  return table;
}

Table rules_table(const TrackingSummary& s) {
  using R = RuleRow;
  const auto share = [](std::uint64_t R::*part, std::uint64_t R::*whole) {
    return in_percent([=](const R& r) { return share_of(r.*part, r.*whole); });
  };
  Table table =
      table_of<R>("rules", {"Whether rules find the views that truly hide a joint", data_text(s)}, s.rules,
                  {{"condition", "condition", as_text(&R::condition)},
                   {"joint", "joint", as_text(&R::group)},
                   {"rule", "rule", as_text(&R::rule)},
                   {"views", "views", as_count(&R::views)},
                   {"hidden (%)", "hidden_percent", share(&R::hidden, &R::views)},
                   {"marked (%)", "marked_percent", share(&R::marked, &R::views)},
                   {"precision (%)", "precision_percent", share(&R::both, &R::marked)},
                   {"recall (%)", "recall_percent", share(&R::both, &R::hidden)}});
  add_notes(table, "rules");
  return table;
}

}  // namespace

std::vector<Table> bound_tables(const ResultsSummary& s, const TrackingSummary& tracking) {
  using R = BoundRow;
  if (tracking.bounds.empty() || s.left_out()) return {};
  const bool has_none = std::ranges::find(s.alignments, "none") != s.alignments.end();
  const std::string alignment = has_none ? "none" : s.alignments.front();
  std::vector<RowColumn<R>> columns{{"condition", "condition", as_text(&R::condition)},
                                    {"joint", "joint", as_text(&R::group)},
                                    {"n", "n", as_count(&R::n)},
                                    {"ranges err by (cm)", "range_error_cm", in_cm(&R::range_error_m)},
                                    {"GDOP", "gdop", as_number(2, &R::mean_gdop)},
                                    {"bound (cm)", "bound_cm", in_cm(&R::bound_m)}};
  for (const std::string& method : s.methods) {
    if (method != "linear" && method != "mean" && !method.starts_with("nonlinear")) continue;
    if (method.find(',') != std::string::npos && method.find("left out") == std::string::npos) continue;
    const auto error_m = [&s, method, alignment](const R& r) {
      const Number* error = find_error(s, method, r.condition, r.group, alignment);
      return error ? error->value : kNaN;
    };
    columns.push_back({method + " (cm)", method + "_mae_cm", in_cm(error_m)});
    columns.push_back({method + " / bound", method + "_by_bound",
                       as_number(2, [error_m](const R& r) { return error_m(r) / r.bound_m(); })});
  }
  Table table =
      table_of<R>("bound",
                  fmt::format("What ranges and geometry leave at best, beside the errors ({}; alignment: {})",
                              data_text(tracking), alignment),
                  tracking.bounds, columns);
  add_notes(table, "bound");
  return {table};
}

std::vector<Table> prediction_tables(const ResultsSummary& s) {
  const Numbers& numbers = s.numbers;
  const NumberKey range{.measure = "range", .statistic = "mean_abs"};
  std::vector<NumberKey> rows;
  for (const std::string& condition : s.conditions)
    for (const std::string& method : s.methods)
      if (numbers.find(NumberKey{.condition = condition, .method = method}.with(range)))
        rows.push_back({.condition = condition, .method = method});
  if (rows.empty()) return {};
  Table table = table_of<NumberKey>(
      "predictions",
      {"What a sensor sees, predicted from the others",
       fmt::format("{}, {} sensors", s.study, s.simulated ? "simulated" : "recorded")},
      rows,
      {{"condition", "condition", as_text(&NumberKey::condition)},
       {"method", "method", as_text(&NumberKey::method)},
       {"along its ray (cm)", "range_cm", interval_of(numbers, range)},
       {"across (cm)", "bearing_cm", interval_of(numbers, {.measure = "bearing", .statistic = "mean"})},
       {"too far by (cm)", "mean_range_cm", interval_of(numbers, {.measure = "range", .statistic = "bias"})},
       {"bones vary by (cm)", "bone_cm", interval_of(numbers, {.measure = "bone", .statistic = "sd"})},
       {"jerk (m/s³)", "jerk_m_s3", interval_of(numbers, {.measure = "jerk", .statistic = "mean"}, 0)},
       {"n", "n", count_of(numbers, range)}});
  add_notes(table, "predictions");
  return {table};
}

std::vector<Table> tracking_tables(const TrackingSummary& s) {
  std::vector<Table> tables;
  if (!s.clocks.empty()) tables.push_back(clocks_table(s));
  if (!s.rays.empty()) tables.push_back(rays_table(s));
  if (!s.rules.empty()) tables.push_back(rules_table(s));
  return tables;
}

std::string ray_text(const RayNoiseRow& row) {
  if (!row.problem.empty()) return fmt::format("along/across the rays: not known, {}", row.problem);
  return fmt::format(
      "sensors disagree by {:.1f} cm along their rays and {:.1f} cm across, ratio {:.2f} ({:.2f} to {:.2f})",
      row.range_m * kCentimetresPerMetre, row.bearing_m * kCentimetresPerMetre, row.ratio, row.ratio_low,
      row.ratio_high);
}

Table checks_table(const TrackingSummary& s) {
  Table table{"checks",
              "What each take was checked by",
              {{"take", "take", true},
               {"sensor or joint", "subject", true},
               {"check", "what", true},
               {"value", "value", false, true},
               {"limit", "limit"},
               {"unit", "unit", true},
               {"beyond", "beyond", true}},
              {},
              {}};
  table.about = data_text(s);
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
