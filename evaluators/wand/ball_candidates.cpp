// SPDX-License-Identifier: MIT
#include "evaluators/wand/ball_candidates.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace trilat {
namespace {

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

}  // namespace

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

}  // namespace trilat
