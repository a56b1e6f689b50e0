// SPDX-License-Identifier: MIT
// Finds the wand's ball in pictures of a room, a person and the wand: ours over the whole image, ours near
// where the ball was, and cv::HoughCircles on the depth image scaled to 8 bits with the depth at the circle's
// middle, which one would write first. The same pictures for all; milliseconds a frame and errors.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "datasets/base/units.h"
#include "evaluators/wand/find_wand.h"
#include "tests/support/depth_pictures.h"

namespace {

using namespace trilat;
using Eigen::Vector3d;

constexpr int kFrames = 60;
constexpr int kRounds = 5;
constexpr double kRadius_m = 0.075;

struct Frame {
  DepthPicture picture;
  Vector3d centre_m;
};

Frame frame_of(const DepthRays& rays, int index) {
  const RandomStream random{11, Purpose::test, static_cast<std::uint64_t>(index)};
  const double depth_m = 0.7 + 3.6 * index / kFrames;
  const Vector3d centre =
      depth_m * Vector3d(random.uniform(0, -0.35, 0.35), random.uniform(1, -0.2, 0.25), 1.0);
  const Vector3d hand = centre + Vector3d(centre.x() > 0.0 ? -0.9 : 0.9, -0.4, 0.5);
  PictureScene scene;
  scene.balls = {{centre, kRadius_m}, {hand, 0.05}, {hand + Vector3d(0.0, 0.45, 0.2), 0.1}};
  scene.sticks = {{centre, hand, 0.01},
                  {hand, hand + Vector3d(0.2, 0.2, 0.2), 0.045},
                  {hand + Vector3d(0.0, 0.3, 0.2), hand + Vector3d(0.0, -0.3, 0.2), 0.15},
                  {hand + Vector3d(-0.1, -0.3, 0.2), hand + Vector3d(-0.12, -1.1, 0.2), kRadius_m},
                  {hand + Vector3d(0.1, -0.3, 0.2), hand + Vector3d(0.12, -1.1, 0.2), kRadius_m}};
  scene.planes = {{Vector3d::UnitZ(), 5.5}, {-Vector3d::UnitY(), 1.4}};
  const AxialNoise noise;
  return {picture_of(scene, rays, &noise, static_cast<std::uint64_t>(index)), centre};
}

std::optional<Vector3d> hough(const DepthPicture& picture, const DepthRays& rays) {
  const cv::Mat depth(picture.height_px, picture.width_px, CV_16UC1,
                      const_cast<std::uint16_t*>(picture.depth_mm.data()));
  cv::Mat grey;
  depth.convertTo(grey, CV_8U, 255.0 / 6000.0);
  cv::medianBlur(grey, grey, 3);
  std::vector<cv::Vec3f> circles;
  cv::HoughCircles(grey, circles, cv::HOUGH_GRADIENT, 1.0, 20.0, 60.0, 10.0, 5, 45);
  std::optional<Vector3d> best;
  double best_px = 3.0;
  for (const cv::Vec3f& circle : circles) {  // the circle whose size fits its depth best
    const int column = std::clamp(static_cast<int>(std::lround(circle[0])), 0, picture.width_px - 1);
    const int row = std::clamp(static_cast<int>(std::lround(circle[1])), 0, picture.height_px - 1);
    const double depth_m = 1e-3 * picture.view().at_mm(column, row);
    if (depth_m < 0.4) continue;
    const double wrong_px =
        std::abs(static_cast<double>(circle[2]) - rays.intrinsics.fx_px * kRadius_m / (depth_m + kRadius_m));
    if (wrong_px >= best_px) continue;
    best_px = wrong_px;
    const Vector3d surface = rays.point_in_sensor_m(column, row, depth_m);
    best = surface * (1.0 + kRadius_m / surface.norm());
  }
  return best;
}

template <class Find>
double report(const char* name, const std::vector<Frame>& frames, Find find) {
  double best_s = 1e9;
  std::vector<double> errors_mm;
  int wrong = 0;
  for (int round = 0; round < kRounds; ++round) {
    errors_mm.clear();
    wrong = 0;
    std::vector<std::optional<Vector3d>> answers;
    const auto start = std::chrono::steady_clock::now();
    for (const Frame& frame : frames) answers.push_back(find(frame));
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    best_s = std::min(best_s, taken.count());
    for (std::size_t i = 0; i < frames.size(); ++i) {
      if (!answers[i]) continue;
      const double error_mm = 1000.0 * (*answers[i] - frames[i].centre_m).norm();
      if (error_mm < 50.0)
        errors_mm.push_back(error_mm);
      else
        ++wrong;
    }
  }
  std::ranges::sort(errors_mm);
  if (errors_mm.empty()) errors_mm.push_back(trilat::kNaN);
  const double ms = 1000.0 * best_s / static_cast<double>(frames.size());
  std::printf(
      "%-22s %7.3f ms/frame  found %2zu of %zu, %d elsewhere; error median %.2f mm, largest %.2f mm\n", name,
      ms, errors_mm.size(), frames.size(), wrong, errors_mm[errors_mm.size() / 2], errors_mm.back());
  return ms;
}

std::optional<Vector3d> position_of(const WandSighting& sighting) {
  if (sighting.status != WandStatus::found) return std::nullopt;
  return sighting.centre_in_sensor_m;
}

}  // namespace

int main() {
  cv::setNumThreads(1);
  const DepthRays rays = depth_rays(DepthIntrinsics{});
  std::vector<Frame> frames;
  for (int i = 0; i < kFrames; ++i) frames.push_back(frame_of(rays, i));
  const FindWandOptions options;
  const double full_ms = report("ours, whole image", frames, [&](const Frame& frame) {
    return position_of(find_wand(frame.picture.view(), rays, options));
  });
  const double near_ms = report("ours, near", frames, [&](const Frame& frame) {
    return position_of(find_wand(frame.picture.view(), rays, options,
                                 Vector3d(frame.centre_m + Vector3d(0.03, 0.03, -0.03))));
  });
  const double hough_ms =
      report("HoughCircles", frames, [&](const Frame& frame) { return hough(frame.picture, rays); });
  std::printf("HoughCircles takes %.1f times as long as the whole image, %.1f times as long as near\n",
              hough_ms / full_ms, hough_ms / near_ms);
  return 0;
}
