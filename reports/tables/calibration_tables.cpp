// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "datasets/paper/printed_tables.h"
#include "reports/tables/accuracy_words.h"
#include "reports/tables/calibration_findings.h"
#include "reports/tables/table.h"
#include "reports/tables/tables.h"

namespace trilat {

namespace {

std::vector<TableValue> paper_row(const PrintedCalibration& paper) {
  const auto n = [](int count) { return TableValue::of(count, 0); };
  return {TableValue::of("the paper, measured"),
          TableValue::of("laser meter"),
          n(paper.recommended_samples),
          no_cell(),
          TableValue::of(paper.recommended_mean_cm, 2),
          TableValue::of(paper.recommended_spread_cm, 2),
          no_cell(),
          no_cell(),
          n(paper.samples),
          no_cell(),
          no_cell(),
          no_cell(),
          no_cell(),
          no_cell(),
          TableValue::of(paper.near_valid_percent, 1),
          TableValue::of("not stated")};
}

// Answers that are farther off than the ball is wide: something else was taken for it.
std::uint64_t wrong_things(const CalibrationSummary& s, std::size_t row) {
  std::uint64_t count = 0;
  for (const WandSample& sample : s.wand_samples)
    count += sample.row == row && sample.error_m > 2.0 * s.ball_radius_m;
  return count;
}

std::vector<TableValue> wand_cells(const WandRow& row, std::uint64_t wrong) {
  const ErrorSpread &inside = row.recommended, &distance = row.recommended_distance, &all = row.all;
  return {TableValue::of(row.method),
          TableValue::of(row.scene),
          count_cell(inside.asked),
          count_cell(inside.answered),
          cm_cell(distance.mean_m, distance.mean_low_m, distance.mean_high_m),
          cm_cell(distance.sd_m),
          cm_cell(inside.mean_m, inside.mean_low_m, inside.mean_high_m),
          cm_cell(inside.sd_m),
          count_cell(all.asked),
          count_cell(all.answered),
          cm_cell(all.mean_m),
          cm_cell(all.median_m),
          cm_cell(all.p95_m),
          count_cell(wrong),
          percent_cell(share_of(row.near.answered, row.near.asked)),
          TableValue::of(all.asked == 0 ? std::string() : statuses_text(row.statuses, all.asked))};
}

std::vector<std::string> wand_notes(const CalibrationSummary& s, const PrintedCalibration& paper) {
  std::vector<std::string> notes{
      fmt::format(
          "\"Inside\" is the paper's recommended range, {:g} to {:g} m and below {:g} degrees from the "
          "central line; \"span\" is all samples; the intervals are 95 % of the mean, by bootstrap over "
          "units; far wall: the ball alone, the wall at 7 m; room: with floor, walls and the person who "
          "holds it.",
          paper.recommended_m[0], paper.recommended_m[1], paper.recommended_below_deg),
      fmt::format("The first row is what the paper states ({}); what its +- is, it does not say. It compared "
                  "with a laser meter, which measures the distance from the sensor to the ball: \"distance\" "
                  "is the error of that alone, \"3-D\" the whole of the ball's place.",
                  paper.source),
      "Eq. 2 keeps what is nearer than about half of the mean depth: before a far wall that is the ball, in "
      "a room the nearest things, the wand or not. This holds for every row of the paper's method but the "
      "mid-range, which keeps what is nearer than half-way between the nearest and the farthest depth, and "
      "ends at the nearest thing: the ball, or in a room the floor where that is nearer."};
  for (std::string& sentence : wand_errata_sentences(s)) notes.push_back(std::move(sentence));
  notes.push_back("Another thing: answers of the span that are off by more than the ball is wide.");
  notes.push_back(
      "Nearer than 0.5 m the simulated sensor gives no depth, and ours refuses a ball whose surface is "
      "nearer: its share there is so by construction. For the paper's method an answer only means that eq. 3 "
      "ended.");
  notes.push_back(
      "A unit's constant depth offset, which no method with a single sensor can know, is in the error of "
      "every row.");
  notes.push_back("All rows but the first are simulated; statuses are those of the span.");
  return notes;
}

constexpr std::array<double, 7> kDistances_m{0.4, 0.8, 1.5, 2.25, 3.0, 3.75, 4.5};
constexpr std::array<double, 5> kAngles_deg{0.0, 9.0, 18.0, 26.0, 35.0};

struct Bin {
  double from, to;
  bool is_last;  // the upper edge belongs to it
  std::uint64_t n = 0, answered = 0;
  double sum_m = 0.0, distance_sum_m = 0.0;

  void add(double where, const WandSample& sample) {
    if (!(where >= from && (where < to || (is_last && where == to)))) return;
    ++n;
    if (!std::isfinite(sample.error_m)) return;
    ++answered;
    sum_m += sample.error_m;
    distance_sum_m += sample.distance_error_m;
  }
  double mean_m(double sum) const { return answered == 0 ? kNoNumber : sum / static_cast<double>(answered); }
};

template <std::size_t N>
std::vector<Bin> bins_of(const std::array<double, N>& edges) {
  std::vector<Bin> bins;
  for (std::size_t i = 0; i + 1 < N; ++i) bins.push_back({edges[i], edges[i + 1], i + 2 == N});
  return bins;
}

// A study may ask for samples beyond the usual edges.
void widen(std::vector<Bin>& bins, double where) {
  bins.front().from = std::min(bins.front().from, where);
  bins.back().to = std::max(bins.back().to, where);
}

void add_bins(Table& table, const WandRow& row, const std::string& of, const std::vector<Bin>& bins) {
  for (const Bin& bin : bins)
    table.rows.push_back({TableValue::of(row.method), TableValue::of(row.scene), TableValue::of(of),
                          TableValue::of(bin.from, -1), TableValue::of(bin.to, -1), count_cell(bin.n),
                          count_cell(bin.answered), cm_cell(bin.mean_m(bin.distance_sum_m)),
                          cm_cell(bin.mean_m(bin.sum_m))});
}

}  // namespace

Table calibration_wand_table(const CalibrationSummary& s) {
  const PrintedCalibration paper = printed_calibration();
  Table table;
  table.id = "wand";
  table.title = fmt::format(
      "Finding the wand, simulated: {} units with {} samples each, the mean of {} frames a sample, ball of "
      "{:g} cm radius, seed {}",
      s.units, s.samples, s.frames, s.ball_radius_m * kCentimetresPerMetre, s.seed);
  table.columns = {{"method", "method", true},
                   {"scene", "scene", true},
                   {"inside: asked", "inside_asked"},
                   {"answered", "inside_answered"},
                   interval_column("distance: mean (cm)", "inside_distance_mean_cm"),
                   {"sd (cm)", "inside_distance_sd_cm"},
                   interval_column("3-D: mean (cm)", "inside_mean_cm"),
                   {"sd (cm)", "inside_sd_cm"},
                   {"span: asked", "span_asked"},
                   {"answered", "span_answered"},
                   {"3-D: mean (cm)", "span_mean_cm"},
                   {"median (cm)", "span_median_cm"},
                   {"p95 (cm)", "span_p95_cm"},
                   {"another thing", "another_thing"},
                   {fmt::format("valid below {:g} m (%)", paper.near_m), "near_valid_percent"},
                   {"statuses", "statuses", true}};
  table.rows.push_back(paper_row(paper));
  for (std::size_t row = 0; row < s.wand.size(); ++row)
    table.rows.push_back(wand_cells(s.wand[row], wrong_things(s, row)));
  table.notes = wand_notes(s, paper);
  return table;
}

Table calibration_bins_table(const CalibrationSummary& s) {
  Table table;
  table.id = "bins";
  table.title = fmt::format(
      "Error of one wand position by distance and by angle, simulated: {} units with {} samples each, seed "
      "{}",
      s.units, s.samples, s.seed);
  table.columns = {{"method", "method", true},   {"scene", "scene", true},
                   {"by", "by", true},           {"from", "from", false, true},
                   {"to", "to", false, true},    {"n", "n"},
                   {"answered", "answered"},     {"distance: mean (cm)", "distance_mean_cm"},
                   {"3-D: mean (cm)", "mean_cm"}};
  for (const char* method : kMainWandMethods)
    for (std::size_t r = 0; r < s.wand.size(); ++r) {
      if (s.wand[r].method != method) continue;
      std::vector<Bin> distances = bins_of(kDistances_m), angles = bins_of(kAngles_deg);
      for (const WandSample& sample : s.wand_samples) {
        widen(distances, sample.distance_m);
        widen(angles, sample.angle_rad * kDegreesPerRad);
      }
      for (const WandSample& sample : s.wand_samples) {
        if (sample.row != r) continue;
        for (Bin& bin : distances) bin.add(sample.distance_m, sample);
        for (Bin& bin : angles) bin.add(sample.angle_rad * kDegreesPerRad, sample);
      }
      add_bins(table, s.wand[r], "distance (m)", distances);
      add_bins(table, s.wand[r], "angle (degrees)", angles);
    }
  table.notes = notes("calibration_bins");
  return table;
}

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
  table.id = "distortion";
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
  table.notes = notes("calibration_distortion");
  return table;
}

Table calibration_rigs_table(const CalibrationSummary& s) {
  Table table;
  table.id = "rigs";
  table.title = fmt::format("Poses of the sensors of whole rigs, simulated: {} wand positions a run, seed {}",
                            s.positions, s.seed);
  table.columns = {{"method", "method", true},
                   {"runs", "runs"},
                   {"sensors", "sensors"},
                   {"without a pose", "sensors_without_pose"},
                   interval_column("position error (cm)", "position_mean_cm"),
                   {"p95 (cm)", "position_p95_cm"},
                   {"max (cm)", "position_max_cm"},
                   {"turned by (degrees)", "rotation_mean_deg"},
                   {"max (degrees)", "rotation_max_deg"},
                   {"within limits (%)", "within_limits_percent"},
                   interval_column("truth in interval (%)", "coverage_percent"),
                   {"error/sigma, position", "position_z_rms"},
                   {"rotation", "rotation_z_rms"},
                   {"Mahalanobis squared", "mahalanobis2_mean"},
                   {"reduced chi squared", "reduced_chi2_mean"}};
  for (const RigRow& r : s.rigs)
    table.rows.push_back(
        {TableValue::of(r.method), count_cell(r.runs), count_cell(r.position.asked),
         count_cell(r.position.asked - r.position.answered),
         cm_cell(r.position.mean_m, r.position.mean_low_m, r.position.mean_high_m), cm_cell(r.position.p95_m),
         cm_cell(r.position.max_m), degree_cell(r.rotation_mean_rad), degree_cell(r.rotation_max_rad),
         percent_cell(r.within_limits_share), percent_cell(r.coverage_share, r.coverage_low, r.coverage_high),
         TableValue::of(r.position_z_rms, 2), TableValue::of(r.rotation_z_rms, 2),
         TableValue::of(r.mahalanobis2_mean, 1), TableValue::of(r.reduced_chi2_mean, 2)});
  table.notes = notes("calibration_rigs");
  return table;
}

Table calibration_effect_table(const CalibrationSummary& s) {
  Table table;
  table.id = "effect";
  table.title = fmt::format("Joints found with uncertain sensors, simulated: {} joints a row, seed {}",
                            s.effect.empty() ? 0 : s.effect.front().joints, s.seed);
  table.columns = {{"calibration", "calibration", true},
                   {"sensor sigma (mm)", "sensor_sigma_mm", false, true},
                   {"range sigma (cm)", "range_sigma_cm", false, true},
                   {"method", "method", true},
                   {"RMSE (cm)", "rmse_cm"},
                   {"Cramer-Rao bound (cm)", "bound_cm"},
                   interval_column("ratio", "ratio"),
                   {"answered (%)", "answered_percent"}};
  for (const EffectRow& r : s.effect) {
    const bool bounded = r.method != "mean";  // the bound is one of estimates from ranges
    table.rows.push_back(
        {TableValue::of(r.calibration), mm_cell(r.sensor_sigma_m), cm_cell(r.range_sigma_m),
         TableValue::of(r.method), cm_cell(r.rmse_m), cm_cell(bounded ? r.bound_m : kNoNumber),
         bounded ? number_cell(3, r.rmse_m / r.bound_m, r.ratio_low, r.ratio_high) : no_cell(),
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
