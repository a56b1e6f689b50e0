// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/median.h"
#include "datasets/base/units.h"
#include "datasets/paper/printed_tables.h"
#include "reports/figures/figures.h"
#include "reports/tables/calibration_findings.h"
#include "reports/tables/table.h"

namespace trilat {
namespace {

constexpr const char* kMissing =
    "The paper's own figure is missing from its source, so only what its text says of it can be shown.";

// The wand figures show a method before a far wall, or in the room when it found nothing there.
const WandRow* shown_row(const CalibrationSummary& s, const std::string& method) {
  const WandRow *alone = wand_row(s, method, "far wall"), *room = wand_row(s, method, "room");
  return room && (!alone || alone->all.answered == 0) ? room : alone;
}

std::vector<FigureSeries> wand_series(const CalibrationSummary& s, bool by_angle) {
  std::vector<FigureSeries> all;
  for (const char* method : kMainWandMethods) {
    const WandRow* row = shown_row(s, method);
    if (!row) continue;
    FigureSeries series{fmt::format("{}, {} ({} of {} answered)", method,
                                    row->scene == "room" ? "in the room" : "before a far wall",
                                    row->all.answered, row->all.asked),
                        FigureSeries::Style::dots,
                        {},
                        {}};
    const auto index = static_cast<std::size_t>(row - s.wand.data());
    for (const WandSample& sample : s.wand_samples)
      if (sample.row == index)
        series.points.push_back({by_angle ? sample.angle_rad * kDegreesPerRad : sample.distance_m,
                                 sample.distance_error_m * kCentimetresPerMetre});
    all.push_back(std::move(series));
  }
  return all;
}

std::string wand_caption(const CalibrationSummary& s, const PrintedCalibration& paper, const char* by) {
  std::string caption = fmt::format(
      "Simulated: error of the distance from the sensor to one wand position {}, the mean of {} frames, {} "
      "units with {} samples each, every unit's constant depth offset included. ",
      by, s.frames, s.units, s.samples);
  for (const char* method : kMainWandMethods)
    if (const WandRow* alone = wand_row(s, method, "far wall"); alone && alone->all.answered == 0)
      caption += fmt::format(
          "\"{}\" found none of {} balls before a far wall, so its samples in the room are shown. ", method,
          alone->all.asked);
  return caption + fmt::format(
                       "The paper claims {:g} +- {:g} cm from {:g} to {:g} m below {:g} degrees, and more "
                       "error outside. {}",
                       paper.recommended_mean_cm, paper.recommended_spread_cm, paper.recommended_m[0],
                       paper.recommended_m[1], paper.recommended_below_deg, kMissing);
}

Figure wand_figure(const CalibrationSummary& s, bool by_angle) {
  const PrintedCalibration paper = printed_calibration();
  Figure figure;
  figure.id = by_angle ? "angle" : "distance";
  figure.title =
      fmt::format("Error of a wand position's distance by {} (simulated)", by_angle ? "angle" : "distance");
  figure.caption = wand_caption(s, paper, by_angle ? "against the angle" : "against the distance");
  figure.x_label = by_angle ? "angle from the central line (degrees)" : "distance from the sensor (m)";
  figure.y_label = "error of the distance (cm)";
  figure.log_y = true;
  figure.series = wand_series(s, by_angle);
  if (by_angle)
    figure.bands = {{0.0, paper.recommended_below_deg,
                     fmt::format("recommended: below {:g}°", paper.recommended_below_deg)}};
  else
    figure.bands = {
        {paper.recommended_m[0], paper.recommended_m[1],
         fmt::format("recommended: {:g} to {:g} m", paper.recommended_m[0], paper.recommended_m[1])}};
  figure.lines = {
      {paper.recommended_mean_cm, fmt::format("paper's mean: {:g} cm", paper.recommended_mean_cm)}};
  return figure;
}

// Bins of equal width, as a map needs them; the paper's limits are edges.
struct Bins {
  double from = 0.0, width = 1.0;
  std::size_t count = 1;

  std::size_t of(double value) const {
    return std::min(count - 1, static_cast<std::size_t>(std::max(0.0, (value - from) / width)));
  }
  std::vector<double> middles() const {
    std::vector<double> result;
    for (std::size_t k = 0; k < count; ++k) result.push_back(from + width * (static_cast<double>(k) + 0.5));
    return result;
  }
};

constexpr double kDistanceBin_m = 0.2, kAngleBin_deg = 6.5;
constexpr double kWorst_cm = 3.0;  // what lies beyond has the colour of the end

Bins bins_over(double from, double to, double width) {
  const double first = std::floor(from / width);
  return {first * width, width, static_cast<std::size_t>(std::max(1.0, std::ceil(to / width) - first))};
}

FigureSeries recommended_outline(const PrintedCalibration& paper) {
  const double near_m = paper.recommended_m[0], far_m = paper.recommended_m[1];
  const double widest_deg = paper.recommended_below_deg;
  return {fmt::format("the paper recommends {:g} to {:g} m, below {:g}°", near_m, far_m, widest_deg),
          FigureSeries::Style::line,
          {{near_m, 0.0}, {near_m, widest_deg}, {far_m, widest_deg}, {far_m, 0.0}}};
}

// Medians of the bins' errors of the distance, and where none of a bin's samples got an answer.
void fill_map(Figure& figure, const std::vector<WandSample>& samples, std::size_t row) {
  double nearest_m = INFINITY, farthest_m = 0.0, widest_rad = 0.0;
  for (const WandSample& sample : samples) {
    nearest_m = std::min(nearest_m, sample.distance_m);
    farthest_m = std::max(farthest_m, sample.distance_m);
    widest_rad = std::max(widest_rad, sample.angle_rad);
  }
  const Bins distances = bins_over(nearest_m, farthest_m, kDistanceBin_m);
  const Bins angles = bins_over(0.0, widest_rad * kDegreesPerRad, kAngleBin_deg);
  std::vector<std::vector<double>> errors_cm(distances.count * angles.count);
  std::vector<bool> asked(errors_cm.size(), false);
  for (const WandSample& sample : samples) {
    if (sample.row != row) continue;
    const std::size_t bin =
        angles.of(sample.angle_rad * kDegreesPerRad) * distances.count + distances.of(sample.distance_m);
    asked[bin] = true;
    if (std::isfinite(sample.distance_error_m))
      errors_cm[bin].push_back(sample.distance_error_m * kCentimetresPerMetre);
  }
  const std::vector<double> x = distances.middles(), y = angles.middles();
  FigureSeries unanswered{"no answer", FigureSeries::Style::dots, {}};
  FigureMap map{x, y, {}, "median error of the distance (cm)", 0.0, kWorst_cm};
  for (std::size_t bin = 0; bin < errors_cm.size(); ++bin) {
    map.values.push_back(errors_cm[bin].empty() ? FigurePoint::kNone : median(errors_cm[bin]));
    if (asked[bin] && errors_cm[bin].empty())
      unanswered.points.push_back({x[bin % x.size()], y[bin / x.size()]});
  }
  figure.map = std::move(map);
  // the second colour stands out from those of the map
  figure.series = {std::move(unanswered), recommended_outline(printed_calibration())};
}

Figure wand_map_figure(const CalibrationSummary& s, const WandRow& row) {
  const PrintedCalibration paper = printed_calibration();
  Figure figure;
  figure.id = usable_id("map-" + row.method);
  figure.title = fmt::format("Error of a wand position's distance, {} {}: {} (simulated)",
                             row.scene == "room" ? "in the" : "before a", row.scene, row.method);
  figure.caption = wand_caption(s, paper, "against distance and angle") +
                   fmt::format(
                       " Colours are medians of bins of {:g} m and {:g} degrees; {:g} cm and more are one "
                       "colour. White: no sample; marked: no sample of the bin got an answer.",
                       kDistanceBin_m, kAngleBin_deg, kWorst_cm);
  figure.x_label = "distance from the sensor (m)";
  figure.y_label = "angle from the central line (degrees)";
  fill_map(figure, s.wand_samples, static_cast<std::size_t>(&row - s.wand.data()));
  return figure;
}

FigureSeries column_series(const DistortionCurve& curve, const std::vector<double>& error_m,
                           const std::string& group) {
  FigureSeries series{fmt::format("unit {}: {}", curve.unit, group), FigureSeries::Style::line, {}, group};
  for (std::size_t c = 0; c < error_m.size(); ++c)
    series.points.push_back({static_cast<double>(c), error_m[c] / kMetresPerMillimetre});
  return series;
}

Figure distortion_figure(const CalibrationSummary& s) {
  const PrintedCalibration paper = printed_calibration();
  const DistortionCurve& first = s.distortion.front();
  Figure figure;
  figure.id = "distortion";
  figure.title =
      fmt::format("A flat wall at {:g} m, middle row of the depth image (simulated)", first.wall_m);
  figure.caption = fmt::format(
      "Simulated: mean absolute error of each column of the middle row over {} frames, one line a unit ({}). "
      "The depth's level is mostly the unit's constant offset. The paper claims \"{}\" errors in the shaded "
      "columns (its last column, {:g}, lies beyond the image). {}",
      first.frames, s.distortion.size(), paper.worse,
      paper.worse_columns.empty() ? 0.0 : paper.worse_columns.back()[1], kMissing);
  figure.x_label = "column (pixels)";
  figure.y_label = "mean absolute error (mm)";
  for (const DistortionCurve& curve : s.distortion)
    figure.series.push_back(column_series(curve, curve.depth_error_m, "depth"));
  for (const DistortionCurve& curve : s.distortion)
    figure.series.push_back(column_series(curve, curve.printed_error_m, "sideways by eq. 4 as printed (E2)"));
  const auto last = static_cast<double>(first.depth_error_m.empty() ? 0 : first.depth_error_m.size() - 1);
  for (const auto& range : paper.worse_columns)
    figure.bands.push_back({range[0], std::min(range[1], last), "columns the paper calls worse"});
  return figure;
}

Figure effect_figure(const CalibrationSummary& s, const std::vector<EffectRow>& rows) {
  Figure figure;
  figure.id = "effect";
  figure.title = "Joints found by nonlinear trilateration with uncertain sensors (simulated)";
  figure.caption = fmt::format(
      "Simulated: RMSE of nonlinear and the Cramer-Rao bound when every sensor is off by a normal error of "
      "that sigma an axis, ranges by {:g} cm, {} joints a point. {} The paper has no such figure.",
      rows.front().range_sigma_m * kCentimetresPerMetre, rows.front().joints, effect_sentence(s));
  figure.x_label = "sensor sigma (mm an axis)";
  figure.y_label = "error of a joint (cm)";
  figure.series = {{"RMSE of nonlinear", FigureSeries::Style::dots, {}, {}},
                   {"Cramer-Rao bound", FigureSeries::Style::line, {}, {}}};
  for (const EffectRow& row : rows) {
    const double sigma_mm = row.sensor_sigma_m / kMetresPerMillimetre;
    figure.series[0].points.push_back({sigma_mm, row.rmse_m * kCentimetresPerMetre});
    figure.series[1].points.push_back({sigma_mm, row.bound_m * kCentimetresPerMetre});
  }
  return figure;
}

}  // namespace

std::vector<Figure> calibration_figures(const CalibrationSummary& s) {
  std::vector<Figure> figures;
  if (!s.wand_samples.empty()) {
    figures.push_back(wand_figure(s, false));
    figures.push_back(wand_figure(s, true));
    for (const char* method : kMainWandMethods)
      if (const WandRow* row = shown_row(s, method)) figures.push_back(wand_map_figure(s, *row));
  }
  if (!s.distortion.empty()) figures.push_back(distortion_figure(s));
  if (const auto rows = assumed_effects(s, "nonlinear"); !rows.empty())
    figures.push_back(effect_figure(s, rows));
  return figures;
}

}  // namespace trilat
