// SPDX-License-Identifier: MIT
#include "pipeline/calibration_study/calibration_tables.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "datasets/paper/printed_tables.h"
#include "pipeline/calibration_study/calibration_findings.h"

namespace trilat {
namespace {

// Answers that are farther off than the ball is wide: something else was taken for it.
std::uint64_t wrong_things(const CalibrationSummary& s, std::size_t row) {
  std::uint64_t count = 0;
  for (const WandSample& sample : s.wand_samples)
    count += sample.row == row && sample.error_m > 2.0 * s.ball_radius_m;
  return count;
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

struct WandBinRow {
  const WandRow* row;
  std::string by;
  Bin bin;
};

// Finding the wand: every method in every scene, and two of them by distance and by angle.
Table calibration_wand_table(const CalibrationSummary& s) {
  using R = WandRow;
  using E = ErrorSpread;
  const PrintedCalibration paper = printed_calibration();
  const auto number = [](double value, int decimals) { return TableValue::of(value, decimals); };
  Table table = table_of<R>(
      "wand",
      fmt::format("Finding the wand, simulated: {} units with {} samples each, the mean of {} frames a "
                  "sample, ball of {:g} cm radius, seed {}",
                  s.units, s.samples, s.frames, s.ball_radius_m * kCentimetresPerMetre, s.seed),
      s.wand,
      {{"method", "method", as_text(&R::method)},
       {"scene", "scene", as_text(&R::scene)},
       {"inside: asked", "inside_asked", of(&R::recommended, as_count(&E::asked))},
       {"answered", "inside_answered", of(&R::recommended, as_count(&E::answered))},
       {"distance: mean (cm)", "inside_distance_mean_cm",
        of(&R::recommended_distance, in_cm(&E::mean_m, &E::mean_low_m, &E::mean_high_m))},
       {"sd (cm)", "inside_distance_sd_cm", of(&R::recommended_distance, in_cm(&E::sd_m))},
       {"3-D: mean (cm)", "inside_mean_cm",
        of(&R::recommended, in_cm(&E::mean_m, &E::mean_low_m, &E::mean_high_m))},
       {"sd (cm)", "inside_sd_cm", of(&R::recommended, in_cm(&E::sd_m))},
       {"span: asked", "span_asked", of(&R::all, as_count(&E::asked))},
       {"answered", "span_answered", of(&R::all, as_count(&E::answered))},
       {"3-D: mean (cm)", "span_mean_cm", of(&R::all, in_cm(&E::mean_m))},
       {"median (cm)", "span_median_cm", of(&R::all, in_cm(&E::median_m))},
       {"p95 (cm)", "span_p95_cm", of(&R::all, in_cm(&E::p95_m))},
       {"another thing", "another_thing",
        as_count([&](const R& r) { return wrong_things(s, static_cast<std::size_t>(&r - s.wand.data())); })},
       {fmt::format("valid below {:g} m (%)", paper.near_m), "near_valid_percent",
        of(&R::near, in_percent([](const E& e) { return share_of(e.answered, e.asked); }))},
       {"statuses", "statuses", as_text([](const R& r) {
          return r.all.asked == 0 ? std::string() : statuses_text(r.statuses, r.all.asked);
        })}});
  table.rows.insert(table.rows.begin(),
                    row_by_key(table, {{"method", TableValue::of("the paper, measured")},
                                       {"scene", TableValue::of("laser meter")},
                                       {"inside_asked", number(paper.recommended_samples, 0)},
                                       {"inside_distance_mean_cm", number(paper.recommended_mean_cm, 2)},
                                       {"inside_distance_sd_cm", number(paper.recommended_spread_cm, 2)},
                                       {"span_asked", number(paper.samples, 0)},
                                       {"near_valid_percent", number(paper.near_valid_percent, 1)},
                                       {"statuses", TableValue::of("not stated")}}));
  add_notes(table, "wand",
            {{"from", fmt::format("{:g}", paper.recommended_m[0])},
             {"to", fmt::format("{:g}", paper.recommended_m[1])},
             {"angle", fmt::format("{:g}", paper.recommended_below_deg)},
             {"source", paper.source}});
  for (const WandErratum& e : wand_errata(s)) table.notes.push_back(e.problem + "; " + e.effect + ".");
  add_notes(table, "wand_rows");
  return table;
}

Table calibration_bins_table(const CalibrationSummary& s) {
  std::vector<WandBinRow> rows;
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
      for (const Bin& bin : distances) rows.push_back({&s.wand[r], "distance (m)", bin});
      for (const Bin& bin : angles) rows.push_back({&s.wand[r], "angle (degrees)", bin});
    }
  Table table = table_of<WandBinRow>(
      "bins",
      fmt::format("Error of one wand position by distance and by angle, simulated: {} units with {} samples "
                  "each, seed {}",
                  s.units, s.samples, s.seed),
      rows,
      {{"method", "method", as_text([](const WandBinRow& r) { return r.row->method; })},
       {"scene", "scene", as_text([](const WandBinRow& r) { return r.row->scene; })},
       {"by", "by", as_text(&WandBinRow::by)},
       {"from", "from", of(&WandBinRow::bin, as_number(-1, &Bin::from))},
       {"to", "to", of(&WandBinRow::bin, as_number(-1, &Bin::to))},
       {"n", "n", of(&WandBinRow::bin, as_count(&Bin::n))},
       {"answered", "answered", of(&WandBinRow::bin, as_count(&Bin::answered))},
       {"distance: mean (cm)", "distance_mean_cm",
        of(&WandBinRow::bin, in_cm([](const Bin& bin) { return bin.mean_m(bin.distance_sum_m); }))},
       {"3-D: mean (cm)", "mean_cm",
        of(&WandBinRow::bin, in_cm([](const Bin& bin) { return bin.mean_m(bin.sum_m); }))}});
  add_notes(table, "calibration_bins");
  return table;
}

std::string paper_distortion_text(const PrintedCalibration& paper) {
  std::string claim;
  for (const auto& range : paper.worse_columns)
    claim += fmt::format("{}{:g} to {:g}", claim.empty() ? "columns " : " and ", range[0], range[1]);
  return fmt::format("{}: \"{}\" than the middle ({:g} m, {} frames)", claim, paper.worse, paper.wall_m,
                     paper.wall_frames);
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
  return {sum / static_cast<double>(values.size()), *std::ranges::max_element(values)};
}

double valid_share(const DistortionCurve& curve) {
  std::uint64_t valid = 0;
  for (std::uint64_t n : curve.valid) valid += n;
  return share_of(valid, curve.frames * curve.valid.size());
}

Table calibration_distortion_table(const CalibrationSummary& s) {
  using R = DistortionCurve;
  using M = ColumnMeans;
  const auto depth = [](const R& r) { return column_means(r.depth_error_m); };
  const auto residual = [](const R& r) { return column_means(r.depth_residual_m); };
  const auto printed = [](const R& r) { return mean_and_max(r.printed_error_m); };
  const auto lens = [](const R& r) { return mean_and_max(r.lens_error_m); };
  Table table = table_of<R>(
      "distortion",
      s.distortion.empty() ? "A flat wall, simulated: not measured"
                           : fmt::format("A flat wall at {:g} m, simulated: mean absolute errors in the "
                                         "middle row, {} frames a unit, seed {}",
                                         s.distortion.front().wall_m, s.distortion.front().frames, s.seed),
      s.distortion,
      {{"unit", "unit", as_text([](const R& r) { return fmt::format("unit {}", r.unit); })},
       {"offset (mm)", "unit_offset_mm", in_mm(&R::unit_offset_m)},
       {"depth, 0-149 (mm)", "depth_left_mm", of(depth, in_mm(&M::left))},
       {"150-350 (mm)", "depth_middle_mm", of(depth, in_mm(&M::middle))},
       {"351-511 (mm)", "depth_right_mm", of(depth, in_mm(&M::right))},
       {"edge/middle", "depth_edge_to_middle", of(depth, as_number(2, &M::edge_to_middle))},
       {"less offset, 0-149 (mm)", "residual_left_mm", of(residual, in_mm(&M::left))},
       {"150-350 (mm)", "residual_middle_mm", of(residual, in_mm(&M::middle))},
       {"351-511 (mm)", "residual_right_mm", of(residual, in_mm(&M::right))},
       {"edge/middle", "residual_edge_to_middle", of(residual, as_number(2, &M::edge_to_middle))},
       {"eq. 4 sideways (mm)", "printed_mean_mm", of(printed, in_mm(&MeanAndMax::mean))},
       {"max (mm)", "printed_max_mm", of(printed, in_mm(&MeanAndMax::max))},
       {"lens sideways (mm)", "lens_mean_mm", of(lens, in_mm(&MeanAndMax::mean))},
       {"valid (%)", "valid_percent", in_percent(valid_share)},
       {"stated", "stated", as_text([](const R&) { return ""; })}});
  table.rows.insert(
      table.rows.begin(),
      row_by_key(table, {{"unit", TableValue::of("the paper")},
                         {"stated", TableValue::of(paper_distortion_text(printed_calibration()))}}));
  add_notes(table, "calibration_distortion");
  return table;
}

Table calibration_rigs_table(const CalibrationSummary& s) {
  using R = RigRow;
  using E = ErrorSpread;
  Table table = table_of<R>(
      "rigs",
      fmt::format("Poses of the sensors of whole rigs, simulated: {} wand positions a run, seed {}",
                  s.positions, s.seed),
      s.rigs,
      {{"method", "method", as_text(&R::method)},
       {"runs", "runs", as_count(&R::runs)},
       {"sensors", "sensors", of(&R::position, as_count(&E::asked))},
       {"without a pose", "sensors_without_pose",
        of(&R::position, as_count([](const E& e) { return e.asked - e.answered; }))},
       {"position error (cm)", "position_mean_cm",
        of(&R::position, in_cm(&E::mean_m, &E::mean_low_m, &E::mean_high_m))},
       {"p95 (cm)", "position_p95_cm", of(&R::position, in_cm(&E::p95_m))},
       {"max (cm)", "position_max_cm", of(&R::position, in_cm(&E::max_m))},
       {"turned by (degrees)", "rotation_mean_deg", in_degrees(&R::rotation_mean_rad)},
       {"max (degrees)", "rotation_max_deg", in_degrees(&R::rotation_max_rad)},
       {"within limits (%)", "within_limits_percent", in_percent(&R::within_limits_share)},
       {"truth in interval (%)", "coverage_percent",
        in_percent(&R::coverage_share, &R::coverage_low, &R::coverage_high)},
       {"error/sigma, position", "position_z_rms", as_number(2, &R::position_z_rms)},
       {"rotation", "rotation_z_rms", as_number(2, &R::rotation_z_rms)},
       {"Mahalanobis squared", "mahalanobis2_mean", as_number(1, &R::mahalanobis2_mean)},
       {"reduced chi squared", "reduced_chi2_mean", as_number(2, &R::reduced_chi2_mean)}});
  add_notes(table, "calibration_rigs");
  return table;
}

// E4 and E5.
std::string pose_effect(const CalibrationSummary& s) {
  const RigRow* printed = rig_row(s, "two positions, eq. 6 and 7 as printed");
  const RigRow* corrected = rig_row(s, "two positions, corrected");
  if (!printed || !corrected) return {};
  return fmt::format("E4 and E5 together: sensors off by {} ({} of {} without a pose) against {} corrected",
                     mean_text(printed->position), printed->position.asked - printed->position.answered,
                     printed->position.asked, mean_text(corrected->position));
}

}  // namespace

StoredTables calibration_tables(const CalibrationSummary& s) {
  StoredTables shown;
  shown.title = s.study;
  shown.asked = "How exactly is the wand found, and how exactly are the sensors of a rig placed?";
  shown.about = fmt::format(
      "Calibration, **simulated** (seed {}): every number here is one of simulated depth images and sensors, "
      "except those that are called the paper's.",
      s.seed);
  shown.sentences = calibration_sentences(s);
  for (const WandErratum& e : wand_errata(s)) shown.errata.emplace(e.id, e.effect);  // the first of each
  for (const char* id : {"E4", "E5", "E19"}) shown.errata.emplace(id, pose_effect(s));
  std::vector<Table>& tables = shown.tables;
  if (!s.wand.empty()) {
    tables.push_back(calibration_wand_table(s));
    tables.back().printed = "calibration";
  }
  if (!s.wand_samples.empty()) tables.push_back(calibration_bins_table(s));
  if (!s.distortion.empty()) tables.push_back(calibration_distortion_table(s));
  if (!s.rigs.empty()) tables.push_back(calibration_rigs_table(s));
  for (std::size_t t = 0; t < 2 && t < tables.size(); ++t) tables[t].shown = Table::Shown::first;
  return shown;
}

}  // namespace trilat
