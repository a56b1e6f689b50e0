// SPDX-License-Identifier: MIT
#include "evaluators/wand/printed_wand.h"

#include <algorithm>
#include <vector>

#include "datasets/base/error.h"
#include "datasets/base/units.h"

namespace trilat {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kMinDistance_cm = 50.0;  // eq. 1
constexpr double kMaxDistance_cm = 650.0;
constexpr double kLeftOut = -1.0;

// D of eq. 1, in centimetres as the paper has it: eq. 5 adds pixels to them.
std::vector<double> standardised_cm(const DepthImageView& image, Variant invalid_pixels) {
  std::vector<double> depth_cm(image.depth_mm.size());
  std::transform(image.depth_mm.begin(), image.depth_mm.end(), depth_cm.begin(), [&](std::uint16_t depth_mm) {
    if (depth_mm == 0 && invalid_pixels == Variant::corrected) return kLeftOut;
    return std::clamp(0.1 * depth_mm, kMinDistance_cm, kMaxDistance_cm);
  });
  return depth_cm;
}

// The labelled pixels (T) are those with a depth of at most `threshold_cm`.
struct PixelSet {
  double threshold_cm = kMaxDistance_cm;
  int pixels = 0;
  double sum_cm = 0.0;
  double min_cm = INFINITY;
  double max_cm = -INFINITY;
  int left = 0, top = 0, right = 0, bottom = 0;  // P_ul and P_br

  bool contains(double depth_cm) const { return depth_cm != kLeftOut && depth_cm <= threshold_cm; }
};

// Labels the pixels inside the box of `within`.
PixelSet label(const std::vector<double>& depth_cm, int width_px, double threshold_cm,
               const PixelSet& within) {
  PixelSet t{.threshold_cm = threshold_cm, .left = width_px, .top = INT32_MAX, .right = -1, .bottom = -1};
  for (int row = within.top; row <= within.bottom; ++row)
    for (int column = within.left; column <= within.right; ++column) {
      const double here_cm = depth_cm[static_cast<std::size_t>(row) * static_cast<std::size_t>(width_px) +
                                      static_cast<std::size_t>(column)];
      if (!t.contains(here_cm)) continue;
      ++t.pixels;
      t.sum_cm += here_cm;
      t.min_cm = std::min(t.min_cm, here_cm);
      t.max_cm = std::max(t.max_cm, here_cm);
      t.left = std::min(t.left, column);
      t.right = std::max(t.right, column);
      t.top = std::min(t.top, row);
      t.bottom = row;
    }
  return t;
}

// R of eq. 2.
double next_threshold_cm(const PixelSet& t, const PrintedWandOptions& options) {
  return options.c_offset *
         (options.binarisation == ThresholdRule::mid_range ? t.min_cm + t.max_cm : t.sum_cm / t.pixels);
}

bool stops(const PixelSet& t, const PrintedWandOptions& options) {  // eq. 3 and erratum E1
  switch (options.binarisation) {
    case ThresholdRule::printed:
      return t.min_cm * options.c_offset >= t.max_cm;
    case ThresholdRule::corrected:
      return t.min_cm >= options.c_offset * t.max_cm;
    case ThresholdRule::mid_range:
      return next_threshold_cm(t, options) >= t.max_cm;
  }
  TRILAT_CHECK(false, "every way to binarise has its stop rule");
}

// D at P_m. Our reading where the paper is silent: the pixel up and left of a middle between pixels, and the
// labelled pixel nearest to it when it is invalid and invalid pixels are left out.
double depth_at_middle_cm(const std::vector<double>& depth_cm, int width_px, const PixelSet& t) {
  const int column = (t.left + t.right) / 2;
  const int row = (t.top + t.bottom) / 2;
  const auto at = [&](int c, int r) {
    return depth_cm[static_cast<std::size_t>(r) * static_cast<std::size_t>(width_px) +
                    static_cast<std::size_t>(c)];
  };
  if (at(column, row) != kLeftOut) return at(column, row);
  int best_px2 = INT32_MAX;
  double best_cm = NAN;
  for (int r = t.top; r <= t.bottom; ++r)
    for (int c = t.left; c <= t.right; ++c) {
      const int away_px2 = (c - column) * (c - column) + (r - row) * (r - row);
      if (away_px2 >= best_px2 || !t.contains(at(c, r))) continue;
      best_px2 = away_px2;
      best_cm = at(c, r);
    }
  return best_cm;
}

// Eq. 4 and 5 with errata E2 and E3, turned to the sensor's frame; NaN where the lens model has no ray.
Vector3d centre_in_sensor_m(const std::vector<double>& depth_cm, const DepthIntrinsics& intrinsics,
                            const PixelSet& t, const PrintedWandOptions& options) {
  const Vector2d middle_px(0.5 * (t.left + t.right), 0.5 * (t.top + t.bottom));
  const double depth = depth_at_middle_cm(depth_cm, intrinsics.width_px, t);
  Vector3d surface_cm = Vector3d::Constant(NAN);
  if (options.projection == Variant::printed) {
    const Vector3d y_down = printed_linear_angle_point(middle_px, depth);
    surface_cm = {y_down.x(), -y_down.y(), y_down.z()};
  } else if (const auto ray = ray_through(intrinsics, middle_px)) {
    surface_cm = depth * Vector3d(ray->x(), ray->y(), 1.0);
  }
  if (options.centre == Variant::printed)
    return kMetresPerCentimetre * (surface_cm + Vector3d(0.0, 0.0, t.right - t.left));
  const double radius_cm = kCentimetresPerMetre * options.ball_radius_m;
  return kMetresPerCentimetre * (1.0 + radius_cm / surface_cm.norm()) * surface_cm;
}

}  // namespace

WandSighting find_wand_as_printed(const DepthImageView& image, const DepthRays& rays,
                                  const PrintedWandOptions& options) {
  TRILAT_CHECK(image.width_px == rays.intrinsics.width_px && image.height_px == rays.intrinsics.height_px &&
                   image.depth_mm.size() == rays.x.size(),
               "the image has the size of the camera's rays");
  const std::vector<double> depth_cm = standardised_cm(image, options.invalid_pixels);
  const PixelSet whole{.right = image.width_px - 1, .bottom = image.height_px - 1};
  const PixelSet everything = label(depth_cm, image.width_px, kMaxDistance_cm, whole);
  WandSighting sighting{.status = WandStatus::no_wand};
  if (everything.pixels == 0) return sighting;
  PixelSet labelled = everything;
  sighting.status = WandStatus::not_ended;
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    // a lower threshold leaves nothing outside the box of the pixels that the last one left
    const double threshold_cm = next_threshold_cm(labelled, options);
    const PixelSet next = label(depth_cm, image.width_px, threshold_cm,
                                threshold_cm <= labelled.threshold_cm ? labelled : whole);
    if (next.pixels == 0) {
      if (iteration == 0) sighting.status = WandStatus::no_wand;
      break;
    }
    labelled = next;
    if (stops(labelled, options)) {
      sighting.status = WandStatus::found;
      break;
    }
  }
  if (sighting.status == WandStatus::no_wand) return sighting;
  sighting.centre_in_sensor_m = centre_in_sensor_m(depth_cm, rays.intrinsics, labelled, options);
  sighting.pixels = labelled.pixels;
  if (!sighting.centre_in_sensor_m.allFinite()) return {.status = WandStatus::no_wand};
  return sighting;
}

}  // namespace trilat
