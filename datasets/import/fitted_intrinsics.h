// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>

#include "datasets/import/body_file_reader.h"

namespace trilat {

// Sums of the straight line pixel = offset + slope * ratio.
struct LineSums {
  double count = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
  void add(double ratio, double pixel);
};

struct FittedIntrinsics {
  DepthIntrinsics intrinsics;
  double rms_px = 0.0;  // of both image axes together
};

// The depth camera from joints whose positions and pixels a file both has: column = cx + fx X/Z and
// row = cy - fy Y/Z, by least squares, without distortion.
class IntrinsicsFit {
 public:
  void add(const Body& body, const JointPixels& depth_px);
  // Nothing with fewer than 200 joints, with too little of the image covered, with more than 1 px left over,
  // or when no Kinect is like that.
  std::optional<FittedIntrinsics> solve() const;

 private:
  LineSums column_, row_;
};

}  // namespace trilat
