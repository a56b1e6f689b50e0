// SPDX-License-Identifier: MIT
#include "pipeline/calibration_study/calibration_study.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/settings.h"
#include "datasets/base/strict_json.h"
#include "datasets/results/results_file.h"
#include "datasets/session/session_types.h"
#include "evaluators/wand/printed_wand.h"
#include "pipeline/calibration_study/calibration_summary.h"
#include "pipeline/calibration_study/calibration_tables.h"
#include "pipeline/calibration_study/rig_trials.h"
#include "pipeline/calibration_study/simulated_run.h"
#include "pipeline/calibration_study/wand_samples.h"
#include "pipeline/claims/paper_claims.h"
#include "pipeline/study/parallel.h"
#include "pipeline/study/study.h"

namespace trilat {
namespace {

constexpr const char* kFormat = "trilat.study";

void tell_rig(Settings& s, RigSpec& rig) {
  s("radius_m", rig.radius_m, {1.0, 4.0}, "of the circle of sensors");
  JsonObject* object = s.reading();
  if (object && object->has("heights_m")) {
    const std::size_t sensors = object->value("heights_m").size();
    if (sensors < 2 || sensors > 8) object->refuse("heights_m", "must hold 2 to 8 heights, one a sensor");
    rig.heights_m = object->numbers("heights_m", sensors);
    object->about({{"heights_m", "one a sensor"}});
  }
  s.write("heights_m", rig.heights_m);
}

void tell_distances(Settings& s, std::vector<double>& distances_m) {
  JsonObject* object = s.reading();
  if (object && object->has("distances_m")) {
    distances_m = object->numbers("distances_m", 2);
    if (!(distances_m[0] >= 0.2 && distances_m[0] < distances_m[1] && distances_m[1] <= 8.0))
      object->refuse("distances_m", "must be [from, to] within 0.2 to 8 m, the nearer first");
    object->about({{"distances_m", "of samples: from, to"}});
  }
  s.write("distances_m", distances_m);
}

void tell(Settings& s, CalibrationSpec& c) {
  JsonObject* object = s.reading();
  s("seed", c.seed, "of every random number");
  s("ball_radius_m", c.ball_radius_m, {0.02, 0.3}, "of the wand's ball");
  s("units", c.units, {1, 1000}, "sensors, each with its own depth offset, wiggle and optics");
  s("samples", c.samples, {0, 100'000}, "wand positions a unit");
  s("near_samples", c.near_samples, {0, 100'000}, "of them nearer than 0.5 m");
  if (object && c.units * (c.samples + c.near_samples) > 200'000)
    object->refuse("samples", "make more than 200000 samples with these units");
  s("frames", c.frames, {1, 100}, "whose mean is a sample");
  tell_distances(s, c.distances_m);
  s("largest_angle_deg", c.largest_angle_deg, {0.0, 40.0}, "of samples, from the central line");
  s("distortion_units", c.distortion_units, {0, 1000}, "that look at a flat wall");
  s("distortion_frames", c.distortion_frames, {1, 1'000'000}, "of the wall, a unit");
  s("wall_m", c.wall_m, {0.5, 8.0}, "distance of the wall");
  s.part("rig", "of the calibrated rigs", [&](Settings& part) { tell_rig(part, c.rig); });
  s("runs", c.runs, {0, 10'000}, "rigs that are calibrated");
  s("positions", c.positions, {3, 1000}, "of the wand, a rig");
  s("position_frames", c.position_frames, {1, 100}, "whose mean is a position");
  s("bodies_s", c.bodies_s, {0.0, 600.0}, "of walking, for the calibration from bodies");
  s("bodies_instants", c.bodies_instants, {1, 10'000}, "at which the bodies are compared");
}

}  // namespace

CalibrationSpec parse_calibration_spec(const Json& json, const std::string& place) {
  JsonObject object(json, place, "");
  CalibrationSpec spec;
  object.format(kFormat);
  object.choice("kind", {"calibration"});
  spec.name = object.text("name");
  if (spec.name.empty()) object.refuse("name", "must not be empty");
  object.about({{"name", "of the study"}});
  Settings settings(object);
  tell(settings, spec);
  object.finish();
  return spec;
}

Json resolved_json(CalibrationSpec spec) {
  Json json{{"format", kFormat}, {"version", 1}, {"kind", "calibration"}, {"name", spec.name}};
  Settings settings(json);
  tell(settings, spec);
  return json;
}

namespace {

constexpr std::uint64_t kBlockFrames = 50;
constexpr int kMiddleRow = kDepthHeight / 2;

// Sums of the middle row's columns, over some frames.
struct RowSums {
  std::vector<std::uint64_t> valid = std::vector<std::uint64_t>(kDepthWidth, 0);
  std::vector<double> depth = std::vector<double>(kDepthWidth, 0.0);
  std::vector<double> residual = depth, printed = depth, lens = depth;

  void merge(const RowSums& later) {
    for (std::size_t c = 0; c < valid.size(); ++c) {
      valid[c] += later.valid[c];
      depth[c] += later.depth[c];
      residual[c] += later.residual[c];
      printed[c] += later.printed[c];
      lens[c] += later.lens[c];
    }
  }
};

// The wall is square to the lens, so its depth is the same everywhere and its points are the rays times it.
void add_row(const DepthImageView& image, const DepthRays& rays, double wall_m, RowSums& sums) {
  double signed_sum_m = 0.0;
  int valid = 0;
  for (int c = 0; c < kDepthWidth; ++c)
    if (const int depth_mm = image.at_mm(c, kMiddleRow); depth_mm > 0) {
      signed_sum_m += 1e-3 * depth_mm - wall_m;
      ++valid;
    }
  if (valid == 0) return;
  const double mean_m = signed_sum_m / valid;
  for (int c = 0; c < kDepthWidth; ++c) {
    const int depth_mm = image.at_mm(c, kMiddleRow);
    if (depth_mm == 0) continue;
    const double depth_m = 1e-3 * depth_mm;
    const auto column = static_cast<std::size_t>(c);
    const double true_x_m = wall_m * double{rays.x[rays.index(c, kMiddleRow)]};
    ++sums.valid[column];
    sums.depth[column] += std::abs(depth_m - wall_m);
    sums.residual[column] += std::abs(depth_m - wall_m - mean_m);
    sums.printed[column] += std::abs(printed_linear_angle_point({c, kMiddleRow}, depth_m).x() - true_x_m);
    sums.lens[column] += std::abs(depth_m * double{rays.x[rays.index(c, kMiddleRow)]} - true_x_m);
  }
}

std::string distortion_item(std::uint64_t unit) { return fmt::format("distortion/unit-{}", unit); }

DistortionCurve measure_unit(const CalibrationSpec& spec, std::uint64_t number, const Watch& watch) {
  const std::uint64_t blocks = (spec.distortion_frames + kBlockFrames - 1) / kBlockFrames;
  const StudyUnit unit = draw_study_unit(spec.seed, number);
  DepthScene wall;
  wall.planes.push_back({-Eigen::Vector3d::UnitZ(), -spec.wall_m});
  std::vector<RowSums> sums(blocks);
  std::atomic<std::uint64_t> done{0};
  parallel_for_index(blocks, 1, [&](std::size_t b) {
    std::vector<std::uint16_t> depth_mm(kDepthPixels);
    const std::uint64_t end = std::min(spec.distortion_frames, (b + 1) * kBlockFrames);
    for (std::uint64_t frame = b * kBlockFrames; frame < end; ++frame) {
      watch.check();
      const RandomStream key{spec.seed, Purpose::depth_pixel, random_item(1, number, 0, frame)};
      unit.renderer.render(wall, {}, key, depth_mm);
      add_row({kDepthWidth, kDepthHeight, depth_mm}, unit.rays, spec.wall_m, sums[b]);
    }
    watch.tell(static_cast<double>(++done) / static_cast<double>(blocks));
  });
  RowSums total;
  for (const RowSums& block : sums) total.merge(block);
  DistortionCurve curve{spec.wall_m, spec.distortion_frames, number,        unit.depth.offset_m, total.valid,
                        total.depth, total.residual,         total.printed, total.lens};
  for (auto* values :
       {&curve.depth_error_m, &curve.depth_residual_m, &curve.printed_error_m, &curve.lens_error_m})
    for (std::size_t c = 0; c < values->size(); ++c)
      (*values)[c] =
          total.valid[c] > 0 ? (*values)[c] / static_cast<double>(total.valid[c]) : ErrorSpread::kNone;
  return curve;
}

// The paper's distortion figure: a flat wall square to the lens, per column of the middle row. Frames are
// rendered and added up one by one; none is kept. An item a unit.
std::vector<Item> distortion_items(const CalibrationSpec& spec) {
  std::vector<Item> items;
  for (std::uint64_t u = 0; u < spec.distortion_units; ++u)
    items.push_back({distortion_item(u), static_cast<double>(spec.distortion_frames),
                     [spec, u](const std::filesystem::path&, const Watch& watch) {
                       return json_of(measure_unit(spec, u, watch));
                     }});
  return items;
}

std::vector<DistortionCurve> read_distortion(const CalibrationSpec& spec, const Outcomes& outcomes) {
  std::vector<DistortionCurve> curves;
  for (std::uint64_t u = 0; u < spec.distortion_units; ++u) {
    const Outcome& outcome = outcomes.at(distortion_item(u));
    const Json json = outcome.json;
    curves.push_back(read_as<DistortionCurve>(JsonObject(json, outcome.place(), "")));
  }
  return curves;
}

CalibrationSummary summarise(const CalibrationSpec& spec, const Outcomes& outcomes) {
  CalibrationSummary summary;
  summary.study = spec.name;
  summary.seed = spec.seed;
  summary.samples = spec.samples;
  summary.units = spec.units;
  summary.frames = spec.frames;
  summary.ball_radius_m = spec.ball_radius_m;
  summary.positions = spec.positions;
  WandSampleResults wand = read_wand(spec, outcomes);
  summary.wand = std::move(wand.rows);
  summary.wand_samples = std::move(wand.samples);
  summary.distortion = read_distortion(spec, outcomes);
  summary.rigs = read_rigs(spec, outcomes);
  summary.claims = claims_of(summary);
  return summary;
}

}  // namespace

Study calibration_study(const CalibrationSpec& spec) {
  const Json resolved = resolved_json(spec);
  std::vector<Item> items = wand_items(spec);
  for (const auto& more : {distortion_items(spec), rig_items(spec)})
    items.insert(items.end(), more.begin(), more.end());
  return {.kind = name_of(StudyKind::calibration),
          .settings = resolved,
          .items = std::move(items),
          .reduce =
              [spec](const Outcomes& outcomes, const std::filesystem::path& results, const Watch&) {
                const CalibrationSummary summary = summarise(spec, outcomes);
                store_tables(results, calibration_tables(summary));
                write_beside(results, StoredFigures{calibration_figures(summary)});
                write_results(results, summary, -1);
              },
          .manifest = [resolved] { return manifest_of_generated(resolved); }};
}

}  // namespace trilat
