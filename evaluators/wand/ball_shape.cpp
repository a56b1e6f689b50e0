// SPDX-License-Identifier: MIT
#include "evaluators/wand/ball_shape.h"

#include <algorithm>
#include <numbers>
#include <optional>

#include <Eigen/Geometry>

namespace trilat {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Uses the points of a circle about the centre, square to the line of sight, with their pixels; nothing for a
// pixel outside the image.
template <class Use>
void on_circle(const DepthIntrinsics& intrinsics, const Vector3d& centre, double circle_radius_m,
               int directions, Use use) {
  const Vector3d aside = centre.unitOrthogonal();
  const Vector3d up = centre.normalized().cross(aside);
  for (int i = 0; i < directions; ++i) {
    const double angle_rad = 2.0 * std::numbers::pi * i / directions;
    const Vector3d point =
        centre + circle_radius_m * (std::cos(angle_rad) * aside + std::sin(angle_rad) * up);
    std::optional<Vector2d> pixel = project(intrinsics, point);
    if (pixel && !(pixel->x() > -0.5 && pixel->y() > -0.5 && pixel->x() < intrinsics.width_px - 0.5 &&
                   pixel->y() < intrinsics.height_px - 0.5))
      pixel.reset();
    use(point, pixel);
  }
}

double depth_at_m(const DepthImageView& image, const Vector2d& pixel_px) {
  return 1e-3 * image.at_mm(static_cast<int>(std::lround(pixel_px.x())),
                            static_cast<int>(std::lround(pixel_px.y())));
}

}  // namespace

std::vector<RayDepth> pixels_around(const DepthImageView& image, const DepthRays& rays,
                                    const Vector3d& centre, double radius_m) {
  const auto middle = project(rays.intrinsics, centre);
  if (!middle) return {};
  // Off the axis a ball's image is stretched by up to 1 / cos^2 of the angle; a half more, for a start that
  // is somewhat off.
  const double stretch = centre.squaredNorm() / (centre.z() * centre.z());
  const double half_px = 1.4 * rays.intrinsics.fx_px * radius_m / centre.norm() * stretch + 2.0;
  const int left = std::max(0, static_cast<int>(middle->x() - half_px));
  const int top = std::max(0, static_cast<int>(middle->y() - half_px));
  const int right = std::min(image.width_px - 1, static_cast<int>(middle->x() + half_px));
  const int bottom = std::min(image.height_px - 1, static_cast<int>(middle->y() + half_px));
  std::vector<RayDepth> pixels;
  if (left > right || top > bottom) return pixels;
  pixels.reserve(static_cast<std::size_t>(right - left + 1) * static_cast<std::size_t>(bottom - top + 1));
  for (int row = top; row <= bottom; ++row)
    for (int column = left; column <= right; ++column) {
      const std::size_t i = rays.index(column, row);
      if (std::isfinite(rays.x[i]))
        pixels.push_back({static_cast<double>(rays.x[i]), static_cast<double>(rays.y[i]),
                          1e-3 * image.at_mm(column, row)});
    }
  return pixels;
}

BallSurroundings surroundings_of(const DepthImageView& image, const DepthRays& rays, const Vector3d& centre,
                                 double radius_m, double circle_radius_m, int directions) {
  int inside = 0, beyond = 0, in_front = 0, unseen = 0;
  on_circle(rays.intrinsics, centre, circle_radius_m, directions,
            [&](const Vector3d&, const std::optional<Vector2d>& pixel) {
              if (!pixel) return;
              ++inside;
              const double depth_m = depth_at_m(image, *pixel);
              unseen += depth_m <= 0.0;
              if (depth_m <= 0.0 || depth_m > centre.z() + 0.3 * radius_m)
                ++beyond;
              else if (depth_m < centre.z() - 1.3 * radius_m)
                ++in_front;
            });
  if (inside == 0) return {};
  const double share = 1.0 / inside;
  return {share * beyond, share * (inside - beyond - in_front), share * in_front, share * unseen};
}

bool worth_fitting(const DepthImageView& image, const DepthRays& rays, const Vector3d& centre,
                   double radius_m) {
  constexpr double kCircle = 0.35;  // in radii, as is the tolerance: a hidden ball's start is off its middle
  constexpr double kTolerance = 0.3;
  const double before_m = radius_m * std::sqrt(1.0 - kCircle * kCircle) * centre.normalized().z();
  int off = 0;
  on_circle(rays.intrinsics, centre, kCircle * radius_m, 8,
            [&](const Vector3d& point, const std::optional<Vector2d>& pixel) {
              off += pixel &&
                     std::abs(depth_at_m(image, *pixel) - (point.z() - before_m)) > kTolerance * radius_m;
            });
  return off <= 2 && surroundings_of(image, rays, centre, radius_m, 1.6 * radius_m, 16).continuing <= 0.2;
}

bool outline_in_image(const DepthIntrinsics& intrinsics, const Vector3d& centre, double radius_m) {
  bool inside = true;
  on_circle(intrinsics, centre, radius_m, 32,
            [&](const Vector3d&, const std::optional<Vector2d>& pixel) { inside &= pixel.has_value(); });
  return inside;
}

namespace {

BallSurroundings wide_surroundings(const DepthImageView& image, const DepthRays& rays, const Vector3d& centre,
                                   double radius_m) {
  const double pixel_m = centre.norm() / rays.intrinsics.fx_px;
  return surroundings_of(image, rays, centre, radius_m, std::max(1.25 * radius_m, radius_m + 1.5 * pixel_m),
                         32);
}

}  // namespace

bool lacks_pixels(const DepthImageView& image, const DepthRays& rays, const BallFit& fit, double radius_m) {
  const int hidden = fit.inner - fit.inner_agreeing - fit.inner_behind - fit.inner_invalid;
  return fit.inner_invalid > 0.08 * fit.inner + 3 * hidden &&
         wide_surroundings(image, rays, fit.centre_in_sensor_m, radius_m).in_front < 0.05;
}

std::string_view not_a_ball(const DepthImageView& image, const DepthRays& rays, const BallFit& fit,
                            double radius_m) {
  if (fit.status != BallFitStatus::fitted) return "no ball fits";
  const Vector3d& centre = fit.centre_in_sensor_m;
  const double pixel_m = centre.norm() / rays.intrinsics.fx_px;
  // Just outside the outline lies what a larger ball still covers at 4.5 m.
  const double close_m = std::max(1.1 * radius_m, radius_m + 0.75 * pixel_m);
  if (surroundings_of(image, rays, centre, radius_m, close_m, 32).continuing > 0.25) return "it is larger";
  const BallSurroundings wide = wide_surroundings(image, rays, centre, radius_m);
  if (wide.continuing > 0.25) return "it goes on beyond the outline";
  if (wide.beyond < 0.4) return "too little of the outline is free";
  if (fit.inner_agreeing < 0.55 * (fit.inner - fit.inner_invalid)) return "too much of the disc is hidden";
  if (fit.inner_agreeing < 0.4 * fit.inner) return "too little of the disc was seen";
  // Corners of the image are up to twice as noisy as the model.
  if (fit.rms_m > 2.0 * fit.expected_rms_m + 0.001) return "it is rougher than noise";
  if (std::abs(fit.radius_excess_m) > std::min(0.1 * radius_m + 3.0 * fit.radius_sigma_m, 0.2 * radius_m))
    return "another radius fits better";
  // A dark corner of the image that cuts the ball goes on beyond it; what lacks pixels otherwise is smaller.
  if (lacks_pixels(image, rays, fit, radius_m) && (fit.inner_behind > 0.02 * fit.inner || wide.unseen < 0.2))
    return "its rim lies within the disc";
  return {};
}

}  // namespace trilat
