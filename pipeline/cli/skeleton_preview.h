// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>

#include "datasets/rig/calibration.h"
#include "datasets/session/session_types.h"

namespace trilat {

// The skeletons that the sensors see, side by side on a terminal of any kind: each sensor's image in dots of
// a Braille pattern, two by four a character.
class SkeletonPreview {
 public:
  // With a calibration, read from `place`, also the person whom all sensors see together, as the first of
  // them would see it.
  explicit SkeletonPreview(std::optional<Calibration> calibration = {}, std::string place = {})
      : calibration_(std::move(calibration)), place_(std::move(place)) {}
  // InputError when the calibration lacks the sensor.
  void see(const std::string& sensor, const DepthIntrinsics& intrinsics, const BodyFrame& frame);
  // For a terminal: from its upper left corner, over what was there. Says how old a view is that is not of
  // the last second.
  std::string picture() const;

 private:
  struct View {
    DepthIntrinsics intrinsics;
    BodyFrame frame;
    RigidTransform world_from_sensor{};  // with a calibration
    std::chrono::steady_clock::time_point seen = std::chrono::steady_clock::now();
  };
  std::map<std::string, View> views_;
  std::optional<Calibration> calibration_;
  std::string place_;
};

// The mean of what the sensors see of one person (of each sensor's bodies the one with the most tracked
// joints), in the first sensor's frame: as the method `mean`. Frames and poses are of the same sensors.
BodyFrame fused_frame(const std::vector<BodyFrame>& frames,
                      const std::vector<RigidTransform>& world_from_sensor);

// Bodies in the sensor's image, of which a pixel is `scale` pixels of the picture. Bones between two tracked
// joints are twice as wide as others, where the picture is larger than the image.
void draw_bodies(cv::Mat& picture, const BodyFrame& frame, const DepthIntrinsics& intrinsics, double scale,
                 const cv::Scalar& colour);

// Bodies in the sensor's image as rows of UTF-8 text, `columns` characters wide.
std::vector<std::string> skeleton_text(const BodyFrame& frame, const DepthIntrinsics& intrinsics,
                                       int columns);

}  // namespace trilat
