// SPDX-License-Identifier: MIT
#include "pipeline/cli/skeleton_preview.h"

#include <algorithm>
#include <optional>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "evaluators/fusion/baselines.h"

namespace trilat {
namespace {

constexpr int kColumns = 38;  // two sensors on a terminal of 80
constexpr int kDotsWide = 2, kDotsHigh = 4;

// The bit of a dot in its character, column by column (Unicode, Braille patterns).
constexpr int kBits[kDotsWide][kDotsHigh] = {{0, 1, 2, 6}, {3, 4, 5, 7}};

std::string utf8(unsigned code) {  // of U+2800 to U+28FF
  return {static_cast<char>(0xe2), static_cast<char>(0xa0 | (code >> 6 & 0x03)),
          static_cast<char>(0x80 | (code & 0x3f))};
}

}  // namespace

void draw_bodies(cv::Mat& picture, const BodyFrame& frame, const DepthIntrinsics& intrinsics, double scale,
                 const cv::Scalar& colour) {
  for (const Body& body : frame.bodies) {
    const auto point_of = [&](std::size_t joint) -> std::optional<cv::Point> {
      const Eigen::Vector3d p =
          Eigen::Map<const Eigen::Vector3f>(body.position_m[joint].data()).cast<double>();
      const auto pixel = body.tracking_state[joint] > 0 ? project(intrinsics, p) : std::nullopt;
      if (!pixel) return std::nullopt;
      return cv::Point(static_cast<int>(scale * pixel->x()), static_cast<int>(scale * pixel->y()));
    };
    for (const Bone& bone : kBones) {
      const auto a = static_cast<std::size_t>(bone.parent), b = static_cast<std::size_t>(bone.child);
      const bool is_tracked = body.tracking_state[a] == 2 && body.tracking_state[b] == 2;
      const auto from = point_of(a), to = point_of(b);
      if (from && to) cv::line(picture, *from, *to, colour, scale > 1.0 && is_tracked ? 2 : 1);
    }
  }
}

std::vector<std::string> skeleton_text(const BodyFrame& frame, const DepthIntrinsics& intrinsics,
                                       int columns) {
  const double dots_per_px = static_cast<double>(columns * kDotsWide) / intrinsics.width_px;
  const int rows = static_cast<int>(intrinsics.height_px * dots_per_px) / kDotsHigh;
  cv::Mat image = cv::Mat::zeros(rows * kDotsHigh, columns * kDotsWide, CV_8UC1);
  draw_bodies(image, frame, intrinsics, dots_per_px, 1);
  std::vector<std::string> text(static_cast<std::size_t>(rows));
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      unsigned code = 0;
      for (int x = 0; x < kDotsWide; ++x)
        for (int y = 0; y < kDotsHigh; ++y)
          if (image.at<unsigned char>(row * kDotsHigh + y, column * kDotsWide + x) != 0)
            code |= 1u << kBits[x][y];
      text[static_cast<std::size_t>(row)] += utf8(code);
    }
  return text;
}

BodyFrame fused_frame(const std::vector<BodyFrame>& frames,
                      const std::vector<RigidTransform>& world_from_sensor) {
  std::vector<const Body*> bodies;
  for (const BodyFrame& frame : frames) {
    const auto tracked = [](const Body& body) { return std::ranges::count(body.tracking_state, 2); };
    const auto most = std::ranges::max_element(frame.bodies, {}, tracked);
    bodies.push_back(most == frame.bodies.end() ? nullptr : &*most);
  }
  Body fused;
  const RigidTransform first_from_world = world_from_sensor.front().inverse();
  std::vector<JointObservation> observations(bodies.size());
  for (std::size_t j = 0; j < kJointCount; ++j) {
    for (std::size_t s = 0; s < bodies.size(); ++s)
      observations[s] =
          bodies[s]
              ? observe(Eigen::Map<const Eigen::Vector3f>(bodies[s]->position_m[j].data()).cast<double>(),
                        static_cast<TrackingState>(bodies[s]->tracking_state[j]), world_from_sensor[s])
              : JointObservation{};
    const PointEstimate mean = solve_mean(observations, {});
    if (!is_usable(mean.status)) continue;
    Eigen::Map<Eigen::Vector3f>(fused.position_m[j].data()) =
        (first_from_world * mean.position_m).cast<float>();
    fused.tracking_state[j] = 2;
  }
  BodyFrame frame;
  frame.bodies = {fused};
  return frame;
}

void SkeletonPreview::see(const std::string& sensor, const DepthIntrinsics& intrinsics,
                          const BodyFrame& frame) {
  View view{intrinsics, frame};
  if (calibration_) view.world_from_sensor = pose_of(*calibration_, sensor, place_).world_from_sensor;
  views_.insert_or_assign(sensor, std::move(view));
}

std::string SkeletonPreview::picture() const {
  std::string picture = "\033[H\033[J";  // from the upper left corner of an empty screen
  std::vector<std::pair<std::string, View>> views;
  for (const auto& [name, view] : views_) {
    const double age_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - view.seen).count();
    views.emplace_back(name + (age_s > 1.0 ? fmt::format(" ({:.0f} s ago)", age_s) : ""), view);
  }
  if (calibration_ && !views.empty()) {
    std::vector<BodyFrame> frames;
    std::vector<RigidTransform> world_from_sensor;
    for (const auto& [name, view] : views) {
      frames.push_back(view.frame);
      world_from_sensor.push_back(view.world_from_sensor);
    }
    views.insert(views.begin(),
                 {"all, as " + views.front().first + " sees it",
                  View{views.front().second.intrinsics, fused_frame(frames, world_from_sensor)}});
  }
  for (auto left = views.begin(); left != views.end();) {
    const auto right = std::next(left);
    const auto a = skeleton_text(left->second.frame, left->second.intrinsics, kColumns);
    std::vector<std::string> b;
    if (right != views.end()) b = skeleton_text(right->second.frame, right->second.intrinsics, kColumns);
    picture += fmt::format("{:<{}}  {}\n", left->first, kColumns, right != views.end() ? right->first : "");
    for (std::size_t row = 0; row < a.size(); ++row)
      picture += a[row] + "  " + (row < b.size() ? b[row] : "") + "\n";
    left = right == views.end() ? right : std::next(right);
  }
  return picture;
}

}  // namespace trilat
