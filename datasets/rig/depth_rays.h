// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "datasets/base/document.h"
#include "datasets/rig/depth_camera.h"

namespace trilat {

// How much a Kinect v2's depth scatters along z, one standard deviation (Fankhauser et al., "Kinect v2 for
// mobile robot navigation: evaluation and modeling", ICAR 2015): for the depth z in metres and the angle
// theta between ray and surface normal, sigma in millimetres =
// level_mm + slope_mm z + square_mm z^2 + angle_mm z^(3/2) theta^2 / (pi/2 - theta)^2.
struct AxialNoise {
  double level_mm = 1.5;
  double slope_mm = -0.5;
  double square_mm = 0.3;
  double angle_mm = 0.1;

  static void fields(auto& self, auto&& f) {
    f("level_mm", self.level_mm, opt("Constant part", {-100.0, 100.0}));
    f("slope_mm", self.slope_mm, opt("Part for each metre of depth", {-100.0, 100.0}));
    f("square_mm", self.square_mm, opt("Part for each square metre", {-100.0, 100.0}));
    f("angle_mm", self.angle_mm, opt("Part by the angle to the surface", {-100.0, 100.0}));
  }
  double sigma_m(double depth_m, double angle_rad) const {
    const double share = angle_rad / (std::numbers::pi / 2.0 - angle_rad);
    return 1e-3 * (level_mm + slope_mm * depth_m + square_mm * depth_m * depth_m +
                   angle_mm * depth_m * std::sqrt(depth_m) * share * share);
  }
};

// A depth image that somebody else owns: millimetres along z, row by row from the upper left pixel, 0 where
// the sensor saw nothing.
struct DepthImageView {
  int width_px = 0;
  int height_px = 0;
  std::span<const std::uint16_t> depth_mm;

  std::uint16_t at_mm(int column, int row) const {
    return depth_mm[static_cast<std::size_t>(row) * static_cast<std::size_t>(width_px) +
                    static_cast<std::size_t>(column)];
  }
};

// The ray of every pixel of a camera, scaled to z = 1, row by row: point_in_sensor_m = depth_m * (x, y, 1).
// Made once a sensor, since undistorting costs far more than reading. NaN where the lens model has no
// inverse.
struct DepthRays {
  DepthIntrinsics intrinsics;
  std::vector<float> x, y;

  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(intrinsics.width_px) +
           static_cast<std::size_t>(column);
  }
  Eigen::Vector3d point_in_sensor_m(int column, int row, double depth_m) const {
    const std::size_t i = index(column, row);
    return depth_m * Eigen::Vector3d(static_cast<double>(x[i]), static_cast<double>(y[i]), 1.0);
  }
};

DepthRays depth_rays(const DepthIntrinsics& intrinsics);

}  // namespace trilat
