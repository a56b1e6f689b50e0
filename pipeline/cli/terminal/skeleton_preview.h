// SPDX-License-Identifier: MIT
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "datasets/calibration/calibration.h"
#include "recorders/frame_source.h"

namespace trilat {

// The skeletons that the sensors see, side by side on a terminal of any kind: each sensor's image in dots of
// a Braille pattern, two by four a character.
class SkeletonPreview {
 public:
  explicit SkeletonPreview(const std::vector<std::unique_ptr<FrameSource>>& sources);
  // With the person whom all sensors see together, as the first of them would see it. InputError when the
  // calibration, read from `place`, lacks a sensor.
  SkeletonPreview(const std::vector<std::unique_ptr<FrameSource>>& sources, const Calibration& calibration,
                  const std::string& place);
  void see(const std::string& sensor, const BodyFrame& frame);
  // For a terminal: from its upper left corner, over what was there.
  std::string picture() const;

 private:
  struct View {
    DepthIntrinsics intrinsics;
    BodyFrame frame;
  };
  std::map<std::string, View> views_;
  std::vector<RigidTransform> world_from_sensor_;  // by view; empty without a calibration
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
