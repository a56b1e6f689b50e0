// SPDX-License-Identifier: MIT
#include "evaluators/wand/find_wand.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <optional>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "datasets/base/error.h"
#include "datasets/rig/depth_rays.h"
#include "evaluators/wand/ball_fit.h"

namespace trilat {
namespace {

// Part of an image, seen at every `stride`-th pixel.
struct ImageWindow {
  int left_px = 0;
  int top_px = 0;
  int width_px = 0;
  int height_px = 0;
  int stride = 1;
};

// A pixel that lies about as deep inside a smooth patch as a ball's middle would.
struct BallCandidate {
  int column = 0;
  int row = 0;
  double depth_m = 0.0;    // of the surface
  double inside_px = 0.0;  // to the patch's nearest depth step, in pixels of the whole image
};

struct BallCandidateOptions {
  double ball_radius_m = 0.075;
  double focal_length_px = 365.0;
  // Distance of a candidate from the nearest depth step, in radii: hidden balls have less, the steep rim and
  // the width of a step take some, heads and walls have more.
  double least_inside = 0.45;
  double most_inside = 1.15;
};

// Surroundings on a circle somewhat larger than the ball's outline, in shares of the directions inside the
// image.
struct BallSurroundings {
  double beyond = 0.0;      // behind the ball's middle, or nothing was seen
  double continuing = 0.0;  // at the ball's depth: the thing is larger than a ball, or its stick
  double in_front = 0.0;    // something hides the ball there
  double unseen = 0.0;      // of those beyond: nothing was seen
};

// The least depth range of a 3 x 3 neighbourhood that counts as a step: twice what a ball's surface changes
// in one pixel at 60 degrees (2 tan(60 degrees) depth / 365 px) and the noise there stay below.
constexpr int kStepBase_mm = 10;
constexpr int kStepShift = 6;  // plus depth / 64

cv::Mat windowed(const DepthImageView& image, const ImageWindow& window) {
  // OpenCV has no view of constant data; nothing writes to this one.
  const cv::Mat whole(image.height_px, image.width_px, CV_16UC1,
                      const_cast<std::uint16_t*>(image.depth_mm.data()));
  const cv::Mat part = whole(cv::Rect(window.left_px, window.top_px, window.width_px, window.height_px));
  if (window.stride == 1) return part;
  cv::Mat thinned((window.height_px + window.stride - 1) / window.stride,
                  (window.width_px + window.stride - 1) / window.stride, CV_16UC1);
  for (int row = 0; row < thinned.rows; ++row) {
    const auto* from = part.ptr<std::uint16_t>(row * window.stride);
    auto* to = thinned.ptr<std::uint16_t>(row);
    for (int column = 0; column < thinned.cols; ++column) to[column] = from[column * window.stride];
  }
  return thinned;
}

constexpr std::uint8_t kFar_px = 250;

// kFar_px where depth is smooth, 0 at steps and where nothing was seen.
cv::Mat smooth_pixels(const cv::Mat& depth_mm) {
  const cv::Mat square = cv::getStructuringElement(cv::MORPH_RECT, {3, 3});
  const int isolated = cv::BORDER_CONSTANT | cv::BORDER_ISOLATED;
  const cv::Point centre(-1, -1);
  const cv::Scalar none = cv::morphologyDefaultBorderValue();
  cv::Mat lowest, highest;
  cv::erode(depth_mm, lowest, square, centre, 1, isolated, none);
  cv::dilate(depth_mm, highest, square, centre, 1, isolated, none);
  cv::Mat smooth(depth_mm.size(), CV_8UC1);
  const int columns = depth_mm.cols;
  for (int row = 0; row < depth_mm.rows; ++row) {
    const auto* low = lowest.ptr<std::uint16_t>(row);
    const auto* high = highest.ptr<std::uint16_t>(row);
    auto* out = smooth.ptr<std::uint8_t>(row);
    for (int column = 0; column < columns; ++column) {
      const bool same = high[column] - low[column] <= kStepBase_mm + (low[column] >> kStepShift);
      out[column] = static_cast<std::uint8_t>(same & (low[column] != 0) ? kFar_px : 0);
    }
  }
  return smooth;
}

// Row by row downwards and upwards: no pixel may exceed its neighbour's value by more than one. Rows depend
// on each other, pixels of a row do not, so the compiler can work on many at once.
void limit_growth_down_columns(cv::Mat& distance_px) {
  const int columns = distance_px.cols;
  const auto limit = [&, columns](int row, int neighbour) {
    auto* here = distance_px.ptr<std::uint8_t>(row);
    const auto* there = distance_px.ptr<std::uint8_t>(neighbour);
    for (int column = 0; column < columns; ++column)
      here[column] = std::min(here[column], static_cast<std::uint8_t>(there[column] + 1));
  };
  for (int row = 1; row < distance_px.rows; ++row) limit(row, row - 1);
  for (int row = distance_px.rows - 2; row >= 0; --row) limit(row, row + 1);
}

// City-block distance to the nearest pixel that is not smooth, at most kFar_px. For a disc it is largest in
// the middle, where it is the radius. (cv::distanceTransform takes ten times as long.)
cv::Mat distance_inside_px(const cv::Mat& smooth) {
  cv::Mat turned;
  cv::transpose(smooth, turned);
  limit_growth_down_columns(turned);
  cv::Mat distance_px;
  cv::transpose(turned, distance_px);
  limit_growth_down_columns(distance_px);
  return distance_px;
}

// Single lost pixels inside a surface take their neighbours' depth.
cv::Mat without_holes(const cv::Mat& depth_mm) {
  cv::Mat closed;
  cv::morphologyEx(depth_mm, closed, cv::MORPH_CLOSE, cv::getStructuringElement(cv::MORPH_RECT, {3, 3}),
                   {-1, -1}, 1, cv::BORDER_CONSTANT | cv::BORDER_ISOLATED);
  return closed;
}

// A plateau of equal maxima, or several maxima of one patch, are one candidate: the deepest inside.
void add(std::vector<BallCandidate>& candidates, const BallCandidate& candidate,
         const BallCandidateOptions& options) {
  const double near_px = 0.4 * options.focal_length_px * options.ball_radius_m / candidate.depth_m;
  for (BallCandidate& other : candidates)
    if (std::abs(other.row - candidate.row) < near_px &&
        std::abs(other.column - candidate.column) < near_px &&
        std::abs(other.depth_m - candidate.depth_m) < options.ball_radius_m) {
      if (candidate.inside_px > other.inside_px) other = candidate;
      return;
    }
  candidates.push_back(candidate);
}

// Patches end where depth steps. A thin stick interrupts a patch's outline without changing how far the
// middle is from it, so it needs no removal. Row by row; one candidate for each local maximum.
std::vector<BallCandidate> ball_candidates(const DepthImageView& image, const ImageWindow& window,
                                           const BallCandidateOptions& options) {
  static const bool one_thread = (cv::setNumThreads(1), true);
  static_cast<void>(one_thread);
  const cv::Mat depth_mm = without_holes(windowed(image, window));
  const cv::Mat inside_px = distance_inside_px(smooth_pixels(depth_mm));
  cv::Mat peak_px;
  cv::dilate(inside_px, peak_px, cv::getStructuringElement(cv::MORPH_RECT, {5, 5}));
  const double scale = 1e-3 * window.stride / options.focal_length_px / options.ball_radius_m;
  std::vector<BallCandidate> candidates;
  for (int row = 0; row < depth_mm.rows; ++row) {
    const auto* inside = inside_px.ptr<std::uint8_t>(row);
    const auto* peak = peak_px.ptr<std::uint8_t>(row);
    const auto* depth = depth_mm.ptr<std::uint16_t>(row);
    for (int column = 0; column < depth_mm.cols; ++column) {
      if (inside[column] < 2 || inside[column] < peak[column]) continue;
      const double radii = inside[column] * depth[column] * scale;
      if (radii < options.least_inside || radii > options.most_inside) continue;
      add(candidates,
          {window.left_px + column * window.stride, window.top_px + row * window.stride, 1e-3 * depth[column],
           static_cast<double>(inside[column] * window.stride)},
          options);
    }
  }
  return candidates;
}

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

// The pixels around a ball's image, those where nothing was seen too; what lies far outside its image and the
// rays the lens model does not know are left out.
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

// Whether a ball may be where a search starts: what is seen on a small circle about the middle lies roughly
// where the ball's surface would (a floor is too steep, a rim too deep), and the thing does not go on around
// it.
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

// Whether the whole outline lies inside the image.
bool outline_in_image(const DepthIntrinsics& intrinsics, const Vector3d& centre, double radius_m) {
  bool inside = true;
  on_circle(intrinsics, centre, radius_m, 32,
            [&](const Vector3d&, const std::optional<Vector2d>& pixel) { inside &= pixel.has_value(); });
  return inside;
}

BallSurroundings wide_surroundings(const DepthImageView& image, const DepthRays& rays, const Vector3d& centre,
                                   double radius_m) {
  const double pixel_m = centre.norm() / rays.intrinsics.fx_px;
  return surroundings_of(image, rays, centre, radius_m, std::max(1.25 * radius_m, radius_m + 1.5 * pixel_m),
                         32);
}

// Whether more of the disc is invalid than lost pixels and the rim of something before the ball explain.
bool lacks_pixels(const DepthImageView& image, const DepthRays& rays, const BallFit& fit, double radius_m) {
  const int hidden = fit.inner - fit.inner_agreeing - fit.inner_behind - fit.inner_invalid;
  return fit.inner_invalid > 0.08 * fit.inner + 3 * hidden &&
         wide_surroundings(image, rays, fit.centre_in_sensor_m, radius_m).in_front < 0.05;
}

// Why a fit is no ball; empty when it is one.
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
    return std::ranges::count_if(balls, [&](const WandSighting& s) { return s.status == status; });
  };
  const auto found = with(WandStatus::found);
  const auto cut = with(WandStatus::cut_by_edge);
  if (found + cut > 1) return refused(WandStatus::several_candidates);
  if (found == 1)
    return *std::ranges::find_if(balls, [](const WandSighting& s) { return s.status == WandStatus::found; });
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
    const bool known = std::ranges::any_of(balls, [&](const WandSighting& other) {
      return (other.centre_in_sensor_m - ball.centre_in_sensor_m).norm() < options.ball_radius_m;
    });
    if (ball.status != WandStatus::no_wand && !known) balls.push_back(ball);
  }
  return the_only_one(balls);
}

WandSighting follow_wand(const DepthImageView& image, const DepthRays& rays, const FindWandOptions& options,
                         std::optional<Vector3d>& before_in_sensor_m) {
  WandSighting sighting = find_wand(image, rays, options, before_in_sensor_m);
  if (before_in_sensor_m && sighting.status != WandStatus::found) sighting = find_wand(image, rays, options);
  before_in_sensor_m.reset();
  if (sighting.status == WandStatus::found) before_in_sensor_m = sighting.centre_in_sensor_m;
  return sighting;
}

}  // namespace trilat
