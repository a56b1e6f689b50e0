// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "datasets/paper/printed_tables.h"
#include "reports/tables/calibration_findings.h"
#include "reports/tables/table.h"
#include "reports/tables/tables.h"

namespace trilat {
namespace {

std::vector<TableValue> paper_distortion_row(const PrintedCalibration& paper, std::size_t columns) {
  std::string claim;
  for (const auto& range : paper.worse_columns)
    claim += fmt::format("{}{:g} to {:g}", claim.empty() ? "columns " : " and ", range[0], range[1]);
  std::vector<TableValue> row(columns, no_cell());
  row.front() = TableValue::of("the paper");
  row.back() = TableValue::of(fmt::format("{}: \"{}\" than the middle ({:g} m, {} frames)", claim,
                                          paper.worse, paper.wall_m, paper.wall_frames));
  return row;
}

// Mean and largest of what is a number.
struct MeanAndMax {
  double mean = kNoNumber, max = kNoNumber;
};
MeanAndMax mean_and_max(std::vector<double> values) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  if (values.empty()) return {};
  double sum = 0.0;
  for (double v : values) sum += v;
  return {sum / static_cast<double>(values.size()), *std::max_element(values.begin(), values.end())};
}

std::vector<TableValue> distortion_cells(const DistortionCurve& curve) {
  const ColumnMeans depth = column_means(curve.depth_error_m),
                    residual = column_means(curve.depth_residual_m);
  const MeanAndMax printed = mean_and_max(curve.printed_error_m), lens = mean_and_max(curve.lens_error_m);
  std::uint64_t valid = 0;
  for (std::uint64_t n : curve.valid) valid += n;
  return {TableValue::of(fmt::format("unit {}", curve.unit)),
          mm_cell(curve.unit_offset_m),
          mm_cell(depth.left),
          mm_cell(depth.middle),
          mm_cell(depth.right),
          TableValue::of(depth.edge_to_middle(), 2),
          mm_cell(residual.left),
          mm_cell(residual.middle),
          mm_cell(residual.right),
          TableValue::of(residual.edge_to_middle(), 2),
          mm_cell(printed.mean),
          mm_cell(printed.max),
          mm_cell(lens.mean),
          percent_cell(share_of(valid, curve.frames * curve.valid.size())),
          TableValue::of("")};
}

}  // namespace

Table calibration_distortion_table(const CalibrationSummary& s) {
  Table table;
  table.id = "calibration_distortion";
  table.title = s.distortion.empty() ? "A flat wall, simulated: not measured"
                                     : fmt::format(
                                           "A flat wall at {:g} m, simulated: mean absolute errors in the "
                                           "middle row, {} frames a unit, seed {}",
                                           s.distortion.front().wall_m, s.distortion.front().frames, s.seed);
  table.columns = {{"unit", "unit", true},
                   {"offset (mm)", "unit_offset_mm"},
                   {"depth, 0-149 (mm)", "depth_left_mm"},
                   {"150-350 (mm)", "depth_middle_mm"},
                   {"351-511 (mm)", "depth_right_mm"},
                   {"edge/middle", "depth_edge_to_middle"},
                   {"less offset, 0-149 (mm)", "residual_left_mm"},
                   {"150-350 (mm)", "residual_middle_mm"},
                   {"351-511 (mm)", "residual_right_mm"},
                   {"edge/middle", "residual_edge_to_middle"},
                   {"eq. 4 sideways (mm)", "printed_mean_mm"},
                   {"max (mm)", "printed_max_mm"},
                   {"lens sideways (mm)", "lens_mean_mm"},
                   {"valid (%)", "valid_percent"},
                   {"stated", "stated", true}};
  table.rows.push_back(paper_distortion_row(printed_calibration(), table.columns.size()));
  for (const DistortionCurve& curve : s.distortion) table.rows.push_back(distortion_cells(curve));
  table.notes = {
      "Less offset: each frame's mean error over the row is taken off first, which leaves noise and what "
      "bends the wall.",
      "Sideways errors are those of a pixel's place across the view: by eq. 4 as printed (E2), and by the "
      "lens model, where only the depth error is left.",
      "The paper's figure of this is missing from its source: there is only its text, whose last column lies "
      "beyond the image's."};
  return table;
}

Table calibration_rigs_table(const CalibrationSummary& s) {
  Table table;
  table.id = "calibration_rigs";
  table.title = fmt::format("Poses of the sensors of whole rigs, simulated: {} wand positions a run, seed {}",
                            s.positions, s.seed);
  table.columns = {{"method", "method", true},
                   {"runs", "runs"},
                   {"sensors", "sensors"},
                   {"without a pose", "sensors_without_pose"},
                   {"position error (cm)", "position_mean_cm"},
                   {"95 % from (cm)", "position_mean_low_cm"},
                   {"to (cm)", "position_mean_high_cm"},
                   {"p95 (cm)", "position_p95_cm"},
                   {"max (cm)", "position_max_cm"},
                   {"turned by (degrees)", "rotation_mean_deg"},
                   {"max (degrees)", "rotation_max_deg"},
                   {"within limits (%)", "within_limits_percent"},
                   {"truth in interval (%)", "coverage_percent"},
                   {"95 % from (%)", "coverage_low_percent"},
                   {"to (%)", "coverage_high_percent"},
                   {"error/sigma, position", "position_z_rms"},
                   {"rotation", "rotation_z_rms"},
                   {"Mahalanobis squared", "mahalanobis2_mean"},
                   {"reduced chi squared", "reduced_chi2_mean"}};
  for (const RigRow& r : s.rigs)
    table.rows.push_back({TableValue::of(r.method), count_cell(r.runs), count_cell(r.position.asked),
                          count_cell(r.position.asked - r.position.answered), cm_cell(r.position.mean_m),
                          cm_cell(r.position.mean_low_m), cm_cell(r.position.mean_high_m),
                          cm_cell(r.position.p95_m), cm_cell(r.position.max_m),
                          degree_cell(r.rotation_mean_rad), degree_cell(r.rotation_max_rad),
                          percent_cell(r.within_limits_share), percent_cell(r.coverage_share),
                          percent_cell(r.coverage_low), percent_cell(r.coverage_high),
                          TableValue::of(r.position_z_rms, 2), TableValue::of(r.rotation_z_rms, 2),
                          TableValue::of(r.mahalanobis2_mean, 1), TableValue::of(r.reduced_chi2_mean, 2)});
  table.notes = {
      "Errors are of the sensors that got a pose (a run that fails leaves all of its sensors without one), "
      "with the mean's 95 % interval over runs; within limits: 5 mm and 0.2 degrees, from bodies 2 cm and "
      "0.5 degrees, of all sensors.",
      "Truth in interval: how often a stated 95 % interval of an axis holds the truth, with its own "
      "interval; a dash where a method states none. Error/sigma is the root mean square over axes, 1 where "
      "what is stated is right; Mahalanobis squared is of all six numbers of a pose, 6 where it is right.",
      "The wand's depth correction expects offsets and wiggles of the size that the simulated units have; "
      "with others its intervals may hold the truth less often.",
      "Two positions: the ball is found by our sphere fit, at places that all sensors can see, and its "
      "movement is level and known exactly; only eq. 6 and 7 are the paper's.",
      "Bodies place the sensors beside one of them, which is not counted.",
      "The paper gives no number for the poses of a rig."};
  return table;
}

Table calibration_effect_table(const CalibrationSummary& s) {
  Table table;
  table.id = "calibration_effect";
  table.title = fmt::format("Joints found with uncertain sensors, simulated: {} joints a row, seed {}",
                            s.effect.empty() ? 0 : s.effect.front().joints, s.seed);
  table.columns = {{"calibration", "calibration", true},
                   {"sensor sigma (mm)", "sensor_sigma_mm", false, true},
                   {"range sigma (cm)", "range_sigma_cm", false, true},
                   {"method", "method", true},
                   {"RMSE (cm)", "rmse_cm"},
                   {"Cramer-Rao bound (cm)", "bound_cm"},
                   {"ratio", "ratio"},
                   {"95 % from", "ratio_low"},
                   {"to", "ratio_high"},
                   {"answered (%)", "answered_percent"}};
  for (const EffectRow& r : s.effect) {
    const bool bounded = r.method != "mean";  // the bound is one of estimates from ranges
    table.rows.push_back({TableValue::of(r.calibration), mm_cell(r.sensor_sigma_m), cm_cell(r.range_sigma_m),
                          TableValue::of(r.method), cm_cell(r.rmse_m),
                          cm_cell(bounded ? r.bound_m : kNoNumber),
                          TableValue::of(bounded ? r.rmse_m / r.bound_m : kNoNumber, 3),
                          TableValue::of(bounded ? r.ratio_low : kNoNumber, 3),
                          TableValue::of(bounded ? r.ratio_high : kNoNumber, 3),
                          percent_cell(share_of(r.answered, r.joints))});
  }
  if (const std::string sentence = effect_sentence(s); !sentence.empty()) table.notes.push_back(sentence);
  table.notes.push_back(
      "Sensor sigma is an axis, assumed, or the root mean square that a calibration was found to have; the "
      "bound takes it as independent between sensors and axes, so a calibration whose errors go together can "
      "lie below it.");
  table.notes.push_back(
      "The bound is one of estimates from ranges alone; the mean uses directions too, here without an error "
      "of their own, so it has none.");
  return table;
}

std::vector<Table> calibration_tables(const CalibrationSummary& s) {
  std::vector<Table> tables;
  if (!s.wand.empty()) tables.push_back(calibration_wand_table(s));
  if (!s.wand_samples.empty()) tables.push_back(calibration_bins_table(s));
  if (!s.distortion.empty()) tables.push_back(calibration_distortion_table(s));
  if (!s.rigs.empty()) tables.push_back(calibration_rigs_table(s));
  if (!s.effect.empty()) tables.push_back(calibration_effect_table(s));
  return tables;
}

}  // namespace trilat
