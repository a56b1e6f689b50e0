// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "datasets/base/document.h"

namespace trilat {

// Pinhole camera with radial (k1, k2, k3) and tangential (p1, p2; OpenCV's naming) distortion.
// Pixels, with pixel centres at integers. Defaults: a typical Kinect v2, from public calibrations.
struct DepthIntrinsics {
  int width_px = 512;
  int height_px = 424;
  double fx_px = 365.456;
  double fy_px = 365.456;
  double cx_px = 254.878;
  double cy_px = 205.395;
  double k1 = 0.0905;
  double k2 = -0.2682;
  double k3 = 0.0951;
  double p1 = 0.0;
  double p2 = 0.0;
};

// Why these intrinsics cannot belong to a Kinect-like camera; empty when they can.
std::string problem_with(const DepthIntrinsics& intrinsics);

// Why images of a Kinect v2's size are hardly its depth camera's with these intrinsics: a focal length far
// from 365 px, which all have to 2 %. Nothing for images of another size.
std::optional<std::string> doubt_about(const DepthIntrinsics& intrinsics);

// The pixel that sees a point of the sensor frame (frames.h: +x is to the image's right, +y up).
// Nothing when the point is not in front of the lens or so far aside (normalised radius above 1.2) that the
// distortion model has left its range. The pixel may lie outside the image.
std::optional<Eigen::Vector2d> project(const DepthIntrinsics& intrinsics,
                                       const Eigen::Vector3d& point_in_sensor_m);

// The ray of a pixel, scaled to z = 1: point = depth * ray. Undistorts by Newton's method; nothing where the
// model cannot be inverted (far outside the image).
std::optional<Eigen::Vector2d> ray_through(const DepthIntrinsics& intrinsics,
                                           const Eigen::Vector2d& pixel_px);

// Equation 4 as printed (erratum E2): angles linear in the pixel, 70 by 60 degrees about (256, 212), and y
// counted downwards. Point of the paper's client frame (x right, y down, z depth).
Eigen::Vector3d printed_linear_angle_point(const Eigen::Vector2d& pixel_px, double depth_m);

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
