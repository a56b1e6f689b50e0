// SPDX-License-Identifier: MIT
#include "evaluators/wand/find_wand.h"

#include <algorithm>
#include <vector>

#include "datasets/base/error.h"
#include "evaluators/wand/ball_candidates.h"
#include "evaluators/wand/ball_fit.h"

namespace trilat {
namespace {

using Eigen::Vector3d;

double outline_px(const DepthRays& rays, const FindWandOptions& options, double depth_m) {
  return rays.intrinsics.fx_px * options.ball_radius_m / depth_m;
}

ImageWindow whole(const DepthImageView& image) { return {0, 0, image.width_px, image.height_px, 1}; }

// Three outlines to each side, thinned so that a close ball costs no more than a far one; empty when the
// place is not in the image.
ImageWindow window_about(const DepthRays& rays, const Vector3d& near_m, const FindWandOptions& options) {
  const auto middle = project(rays.intrinsics, near_m);
  if (!middle) return {};
  constexpr double kEnough_px = 12.0;
  const double ball_px = outline_px(rays, options, near_m.z());
  const double half_px = 3.0 * ball_px + 6.0;
  const auto within = [](double value, int size) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(size)));
  };
  const int left = within(middle->x() - half_px, rays.intrinsics.width_px);
  const int top = within(middle->y() - half_px, rays.intrinsics.height_px);
  const int right = within(middle->x() + half_px, rays.intrinsics.width_px);
  const int bottom = within(middle->y() + half_px, rays.intrinsics.height_px);
  return {left, top, right - left, bottom - top, std::max(1, static_cast<int>(ball_px / kEnough_px))};
}

// The middle of a ball whose nearest point the candidate is.
std::optional<Vector3d> start_of(const BallCandidate& candidate, const DepthRays& rays, double radius_m) {
  const Vector3d surface = rays.point_in_sensor_m(candidate.column, candidate.row, candidate.depth_m);
  if (!surface.allFinite()) return std::nullopt;
  return Vector3d(surface * (1.0 + radius_m / surface.norm()));
}

WandSighting judged(const DepthImageView& image, const DepthRays& rays, const FindWandOptions& options,
                    const BallCandidate& candidate) {
  WandSighting sighting{.status = WandStatus::no_wand};
  const double radius_m = options.ball_radius_m;
  const auto start = start_of(candidate, rays, radius_m);
  if (!start || !worth_fitting(image, rays, *start, radius_m)) return sighting;
  const BallFit fit = fit_ball(pixels_around(image, rays, *start, radius_m), *start,
                               {.radius_m = radius_m,
                                .noise = options.noise,
                                .lateral_sigma_m = options.lateral_sigma_m,
                                .pixel_rad = 1.0 / rays.intrinsics.fx_px});
  if (!not_a_ball(image, rays, fit, radius_m).empty()) return sighting;
  const Vector3d& centre = fit.centre_in_sensor_m;
  if (centre.z() - radius_m < options.nearest_m || centre.z() > options.farthest_m)
    sighting.status = WandStatus::out_of_range;
  else if (lacks_pixels(image, rays, fit, radius_m) || !outline_in_image(rays.intrinsics, centre, radius_m))
    sighting.status = WandStatus::cut_by_edge;
  else
    sighting.status = WandStatus::found;
  sighting.centre_in_sensor_m = centre;
  sighting.covariance_m2 = fit.covariance_m2;
  sighting.rms_m = fit.rms_m;
  sighting.pixels = fit.used;
  return sighting;
}

WandSighting refused(WandStatus status) { return {.status = status}; }

// A ball cut by the edge counts as a ball when there is another; one out of range does not.
WandSighting the_only_one(const std::vector<WandSighting>& balls) {
  const auto with = [&](WandStatus status) {
    return std::count_if(balls.begin(), balls.end(),
                         [&](const WandSighting& s) { return s.status == status; });
  };
  const auto found = with(WandStatus::found);
  const auto cut = with(WandStatus::cut_by_edge);
  if (found + cut > 1) return refused(WandStatus::several_candidates);
  if (found == 1)
    return *std::find_if(balls.begin(), balls.end(),
                         [](const WandSighting& s) { return s.status == WandStatus::found; });
  if (cut == 1) return refused(WandStatus::cut_by_edge);
  return refused(with(WandStatus::out_of_range) > 0 ? WandStatus::out_of_range : WandStatus::no_wand);
}

}  // namespace

WandSighting find_wand(const DepthImageView& image, const DepthRays& rays, const FindWandOptions& options,
                       const std::optional<Vector3d>& near_in_sensor_m) {
  TRILAT_CHECK(image.width_px == rays.intrinsics.width_px && image.height_px == rays.intrinsics.height_px,
               "the image has the size of the camera's rays");
  TRILAT_CHECK(image.depth_mm.size() == rays.x.size() && rays.y.size() == rays.x.size(),
               "the image has a depth and the camera a ray for every pixel");
  TRILAT_CHECK(options.ball_radius_m > 0.0, "the ball has a radius");
  const ImageWindow window = near_in_sensor_m ? window_about(rays, *near_in_sensor_m, options) : whole(image);
  std::vector<WandSighting> balls;
  if (window.width_px < 1 || window.height_px < 1) return refused(WandStatus::no_wand);
  for (const BallCandidate& candidate :
       ball_candidates(image, window,
                       {.ball_radius_m = options.ball_radius_m, .focal_length_px = rays.intrinsics.fx_px})) {
    const WandSighting ball = judged(image, rays, options, candidate);
    const bool known = std::any_of(balls.begin(), balls.end(), [&](const WandSighting& other) {
      return (other.centre_in_sensor_m - ball.centre_in_sensor_m).norm() < options.ball_radius_m;
    });
    if (ball.status != WandStatus::no_wand && !known) balls.push_back(ball);
  }
  return the_only_one(balls);
}

}  // namespace trilat
