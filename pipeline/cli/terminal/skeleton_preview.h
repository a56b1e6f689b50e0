// SPDX-License-Identifier: MIT
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "recorders/frame_source.h"

namespace trilat {

// The skeletons that the sensors see, side by side on a terminal of any kind: each sensor's image in dots of
// a Braille pattern, two by four a character.
class SkeletonPreview {
 public:
  explicit SkeletonPreview(const std::vector<std::unique_ptr<FrameSource>>& sources);
  void see(const std::string& sensor, const BodyFrame& frame);
  // For a terminal: from its upper left corner, over what was there.
  std::string picture() const;

 private:
  struct View {
    DepthIntrinsics intrinsics;
    BodyFrame frame;
  };
  std::map<std::string, View> views_;
};

// Bodies in the sensor's image as rows of UTF-8 text, `columns` characters wide.
std::vector<std::string> skeleton_text(const BodyFrame& frame, const DepthIntrinsics& intrinsics,
                                       int columns);

}  // namespace trilat
