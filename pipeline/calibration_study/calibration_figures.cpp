// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "datasets/base/median.h"
#include "datasets/base/units.h"
#include "pipeline/calibration_study/calibration_numbers.h"
#include "pipeline/calibration_study/place_samples.h"

namespace trilat {
namespace {

constexpr const char* kMissing =
    "The paper's own figure is missing from its source, so only what its text says of it can be shown.";
constexpr double kDistanceBin_m = 0.25;

// Medians over bins of the distance, of the samples of one method between two angles.
FigureSeries wand_curve(const WandRecording& recording, std::size_t method, double from_deg, double to_deg) {
  std::map<long, std::vector<double>> errors_cm;
  for (const WandSample& sample : recording.samples) {
    const double angle_deg = sample.angle_rad * kDegreesPerRad;
    if (sample.method == method && angle_deg >= from_deg && angle_deg < to_deg &&
        std::isfinite(sample.distance_error_m))
      errors_cm[std::lround(std::floor(sample.distance_m / kDistanceBin_m))].push_back(
          sample.distance_error_m * kCentimetresPerMetre);
  }
  FigureSeries curve{fmt::format("{:g} to {:g}°", from_deg, to_deg), FigureSeries::Style::line_and_dots, {}};
  for (auto& [bin, values_cm] : errors_cm)
    curve.points.push_back({(static_cast<double>(bin) + 0.5) * kDistanceBin_m, median(values_cm)});
  return curve;
}

// Each main method in the first recording in which it found anything.
Figure wand_figure(bool simulated, const std::vector<WandRecording>& wands) {
  constexpr std::array kAngles_deg{0.0, 9.0, 18.0, 26.0, 40.0};  // edges; the paper recommends below 26
  Figure figure;
  figure.id = "distance-and-angle";
  figure.title =
      fmt::format("Error of the ball's distance, by distance and angle ({})", source_text(simulated));
  figure.caption = fmt::format(
      "{}: error of the distance from the sensor to one place of the ball, every sensor's constant depth "
      "offset "
      "included. Points are medians over {:g} m of distance; lines are ranges of the angle from the lens' "
      "axis. The "
      "paper claims {:g} +- {:g} cm from {:g} to {:g} m (shaded) below {:g} degrees, and more error outside. "
      "{}",
      simulated ? "Simulated" : "Recorded", kDistanceBin_m, paper_calibration().recommended_mean_cm,
      paper_calibration().recommended_spread_cm, paper_calibration().recommended_m[0],
      paper_calibration().recommended_m[1], paper_calibration().recommended_below_deg, kMissing);
  figure.x_label = "distance from the sensor (m)";
  figure.y_label = "error of the distance (cm)";
  figure.log_y = true;
  for (const char* method : kMainWandMethods)
    for (const WandRecording& recording : wands) {
      const std::size_t number = wand_method(method);
      if (std::ranges::none_of(recording.samples, [&](const WandSample& sample) {
            return sample.method == number && std::isfinite(sample.distance_error_m);
          }))
        continue;
      for (std::size_t k = 0; k + 1 < kAngles_deg.size(); ++k) {
        FigureSeries curve = wand_curve(recording, number, kAngles_deg[k], kAngles_deg[k + 1]);
        curve.panel = figure.panels.size();
        if (!curve.points.empty()) figure.series.push_back(std::move(curve));
      }
      figure.panels.emplace_back(method);
      figure.caption += fmt::format(" {}: {}.", method, recording.name);
      break;
    }
  figure.bands = {{paper_calibration().recommended_m[0], paper_calibration().recommended_m[1],
                   fmt::format("recommended: {:g} to {:g} m", paper_calibration().recommended_m[0],
                               paper_calibration().recommended_m[1])}};
  figure.lines = {{paper_calibration().recommended_mean_cm,
                   fmt::format("paper's mean: {:g} cm", paper_calibration().recommended_mean_cm)}};
  return figure;
}

FigureSeries column_series(const WallRow& row, const std::vector<double>& error_m, const std::string& group) {
  FigureSeries series{fmt::format("{}: {}", row.sensor, group), FigureSeries::Style::line, {}, group};
  for (std::size_t c = 0; c < error_m.size(); ++c)
    series.points.push_back({static_cast<double>(c), error_m[c] / kMetresPerMillimetre});
  return series;
}

// Columns of the recording whose wall is nearest to the paper's distance.
Figure wall_figure(bool simulated, const std::vector<WallRow>& walls) {
  const WallRow& nearest = *std::ranges::min_element(
      walls, {}, [](const WallRow& row) { return std::abs(row.distance_m - paper_calibration().wall_m); });
  Figure figure;
  figure.id = "distortion";
  figure.title = fmt::format("A flat wall, middle row of the depth image ({})", source_text(simulated));
  figure.caption = fmt::format(
      "{}: mean absolute error of each column of the middle row over {} frames, one line a sensor ({}, "
      "{:.1f} m): of "
      "the depth from a fitted plane, and sideways by eq. 4. The paper claims \"{}\" errors in the shaded "
      "columns "
      "(its last column, {:g}, lies beyond the image). {}",
      simulated ? "Simulated" : "Recorded", nearest.frames, nearest.recording, nearest.distance_m,
      paper_calibration().worse,
      paper_calibration().worse_columns.empty() ? 0.0 : paper_calibration().worse_columns.back()[1],
      kMissing);
  figure.x_label = "column (pixels)";
  figure.y_label = "mean absolute error (mm)";
  for (const WallRow& row : walls)
    if (row.recording == nearest.recording)
      figure.series.push_back(column_series(row, row.residual_m, "depth from the plane"));
  for (const WallRow& row : walls)
    if (row.recording == nearest.recording)
      figure.series.push_back(column_series(row, row.printed_error_m, "sideways by eq. 4 as printed (E2)"));
  const auto last = static_cast<double>(nearest.residual_m.empty() ? 0 : nearest.residual_m.size() - 1);
  for (const auto& range : paper_calibration().worse_columns)
    figure.bands.push_back({range[0], std::min(range[1], last), "columns the paper calls worse"});
  return figure;
}

}  // namespace

std::vector<Figure> calibration_figures(bool simulated, const CalibrationRecordings& recordings) {
  std::vector<Figure> figures;
  if (!recordings.wands.empty()) figures.push_back(wand_figure(simulated, recordings.wands));
  if (!recordings.walls.empty()) figures.push_back(wall_figure(simulated, recordings.walls));
  if (!figures.empty()) figures.front().is_first = true;
  return figures;
}

}  // namespace trilat
