// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>

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

}  // namespace trilat
