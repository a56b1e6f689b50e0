// SPDX-License-Identifier: MIT
#include <array>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "datasets/base/median.h"
#include "datasets/base/units.h"
#include "datasets/paper/printed_tables.h"
#include "pipeline/calibration_study/calibration_findings.h"
#include "pipeline/calibration_study/calibration_tables.h"

namespace trilat {
namespace {

constexpr const char* kMissing =
    "The paper's own figure is missing from its source, so only what its text says of it can be shown.";

constexpr double kDistanceBin_m = 0.25;
constexpr std::array kLineAngles_deg{0.0, 9.0, 18.0, 26.0, 40.0};  // edges; the paper recommends below 26

// Ways to find the wand, each before a far wall, or in the room when it found nothing there.
std::vector<const WandRow*> shown_rows(const CalibrationSummary& s) {
  std::vector<const WandRow*> rows;
  for (const char* method : kMainWandMethods) {
    const WandRow *alone = wand_row(s, method, "far wall"), *room = wand_row(s, method, "room");
    if (const WandRow* row = room && (!alone || alone->all.answered == 0) ? room : alone) rows.push_back(row);
  }
  return rows;
}

// Medians over bins of the distance, of the samples of one row between two angles.
FigureSeries wand_curve(const CalibrationSummary& s, const WandRow& row, double from_deg, double to_deg) {
  const auto index = static_cast<std::size_t>(&row - s.wand.data());
  std::map<long, std::vector<double>> errors_cm;
  for (const WandSample& sample : s.wand_samples) {
    const double angle_deg = sample.angle_rad * kDegreesPerRad;
    if (sample.row == index && angle_deg >= from_deg && angle_deg < to_deg &&
        std::isfinite(sample.distance_error_m))
      errors_cm[std::lround(std::floor(sample.distance_m / kDistanceBin_m))].push_back(
          sample.distance_error_m * kCentimetresPerMetre);
  }
  FigureSeries curve{fmt::format("{:g} to {:g}°", from_deg, to_deg), FigureSeries::Style::line_and_dots, {}};
  for (auto& [bin, values_cm] : errors_cm)
    curve.points.push_back({(static_cast<double>(bin) + 0.5) * kDistanceBin_m, median(values_cm)});
  return curve;
}

// The paper's own figure: error of a wand position against its distance and its angle.
Figure wand_figure(const CalibrationSummary& s) {
  const PrintedCalibration paper = printed_calibration();
  Figure figure;
  figure.id = "distance-and-angle";
  figure.title = "Error of a wand position's distance, by distance and angle (simulated)";
  figure.caption = fmt::format(
      "Simulated: error of the distance from the sensor to one wand position, the mean of {} frames, {} "
      "units with {} samples each, every unit's constant depth offset included. Points are medians over {:g} "
      "m of distance; lines are ranges of the angle from the central line. The paper claims {:g} +- {:g} cm "
      "from {:g} to {:g} m (shaded) below {:g} degrees, and more error outside. {}",
      s.frames, s.units, s.samples, kDistanceBin_m, paper.recommended_mean_cm, paper.recommended_spread_cm,
      paper.recommended_m[0], paper.recommended_m[1], paper.recommended_below_deg, kMissing);
  figure.x_label = "distance from the sensor (m)";
  figure.y_label = "error of the distance (cm)";
  figure.log_y = true;
  for (const WandRow* row : shown_rows(s)) {
    for (std::size_t k = 0; k + 1 < kLineAngles_deg.size(); ++k) {
      FigureSeries curve = wand_curve(s, *row, kLineAngles_deg[k], kLineAngles_deg[k + 1]);
      curve.panel = figure.panels.size();
      if (!curve.points.empty()) figure.series.push_back(std::move(curve));
    }
    figure.panels.push_back(
        fmt::format("{}, {}", row->method, row->scene == "room" ? "in the room" : "far wall"));
  }
  figure.bands = {
      {paper.recommended_m[0], paper.recommended_m[1],
       fmt::format("recommended: {:g} to {:g} m", paper.recommended_m[0], paper.recommended_m[1])}};
  figure.lines = {
      {paper.recommended_mean_cm, fmt::format("paper's mean: {:g} cm", paper.recommended_mean_cm)}};
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

}  // namespace

std::vector<Figure> calibration_figures(const CalibrationSummary& s) {
  std::vector<Figure> figures;
  if (!s.wand_samples.empty()) figures.push_back(wand_figure(s));
  if (!s.distortion.empty()) figures.push_back(distortion_figure(s));
  if (!figures.empty()) figures.front().is_first = true;
  return figures;
}

}  // namespace trilat
