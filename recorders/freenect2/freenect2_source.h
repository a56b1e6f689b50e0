// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "recorders/frame_source.h"

namespace trilat {

struct Freenect2Options {
  std::string serial;            // empty: the only sensor
  std::string pipeline = "cpu";  // who decodes; others as the library was built: opengl, opencl, cuda
  double min_depth_m = 0.5, max_depth_m = 8.0;
  bool bilateral_filter = true, edge_aware_filter = true;
  std::chrono::milliseconds silence_limit{5000};  // without frames the sensor is taken for unplugged
};

// True where this program was built with libfreenect2.
bool has_freenect2();

// Depth of a Kinect v2 through libfreenect2, without bodies. Pixels lie as those of the Kinect SDK; ticks are
// 0.125 ms. InputError naming `place` where there is no such sensor, or no libfreenect2 in this build; next()
// throws it where the sensor falls silent.
std::unique_ptr<FrameSource> open_freenect2(const Freenect2Options& options, const std::string& place);

}  // namespace trilat
