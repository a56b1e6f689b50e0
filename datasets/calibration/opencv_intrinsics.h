// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "datasets/geometry/depth_camera.h"

namespace trilat {

// The depth camera's intrinsics from a calibration file of OpenCV's FileStorage (YAML, XML or JSON), such as
// iai_kinect2's calib_ir.yaml: `cameraMatrix` and `distortionCoefficients` (k1 k2 p1 p2 and, when there, k3;
// further terms must be zero), or the same as `camera_matrix` and `distortion_coefficients`. The file does
// not name the image's size. InputError, with the file as the place, for anything else.
DepthIntrinsics read_opencv_intrinsics(const std::filesystem::path& path, int width_px, int height_px);

}  // namespace trilat
