// SPDX-License-Identifier: MIT
#include "pipeline/calibration_study/distortion.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/session/session_types.h"
#include "evaluators/wand/printed_wand.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

constexpr std::uint64_t kBlockFrames = 50;
constexpr int kMiddleRow = kDepthHeight / 2;

// Of the middle row's columns, over some frames.
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

Json json_of(const DistortionCurve& curve) {
  return {{"unit_offset_m", curve.unit_offset_m},
          {"valid", curve.valid},
          {"depth_error_m", numbers_json(curve.depth_error_m)},
          {"depth_residual_m", numbers_json(curve.depth_residual_m)},
          {"printed_error_m", numbers_json(curve.printed_error_m)},
          {"lens_error_m", numbers_json(curve.lens_error_m)}};
}

DistortionCurve read_curve(const CalibrationSpec& spec, std::uint64_t unit, const Json& json,
                           const std::string& place) {
  JsonObject object(json, place, "");
  const auto column = [&](const char* key) { return object.numbers_or_none(key, kDepthWidth); };
  DistortionCurve curve{spec.wall_m,
                        spec.distortion_frames,
                        unit,
                        object.number("unit_offset_m"),
                        object.counts("valid", kDepthWidth),
                        column("depth_error_m"),
                        column("depth_residual_m"),
                        column("printed_error_m"),
                        column("lens_error_m")};
  if (std::any_of(curve.valid.begin(), curve.valid.end(),
                  [&](std::uint64_t frames) { return frames > spec.distortion_frames; }))
    object.refuse("valid", "counts more frames than there are");
  object.finish();
  return curve;
}

}  // namespace

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
    curves.push_back(read_curve(spec, u, outcome.json(), outcome.place()));
  }
  return curves;
}

}  // namespace trilat
