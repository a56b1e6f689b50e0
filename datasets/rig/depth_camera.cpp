// SPDX-License-Identifier: MIT
#include "datasets/rig/depth_camera.h"

#include <cmath>

#include <Eigen/LU>

#include "datasets/base/units.h"

namespace trilat {
namespace {

constexpr double kMaxNormalisedRadius = 1.2;

// Distorts normalised image coordinates and gives the Jacobian (Brown's model, as in OpenCV).
Eigen::Vector2d distort(const DepthIntrinsics& in, const Eigen::Vector2d& n, Eigen::Matrix2d* jacobian) {
  const double x = n.x();
  const double y = n.y();
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (in.k1 + r2 * (in.k2 + r2 * in.k3));
  if (jacobian) {
    const double slope = in.k1 + r2 * (2.0 * in.k2 + r2 * 3.0 * in.k3);
    (*jacobian)(0, 0) = radial + 2.0 * x * x * slope + 2.0 * in.p1 * y + 6.0 * in.p2 * x;
    (*jacobian)(0, 1) = 2.0 * x * y * slope + 2.0 * in.p1 * x + 2.0 * in.p2 * y;
    (*jacobian)(1, 0) = (*jacobian)(0, 1);
    (*jacobian)(1, 1) = radial + 2.0 * y * y * slope + 6.0 * in.p1 * y + 2.0 * in.p2 * x;
  }
  return {x * radial + 2.0 * in.p1 * x * y + in.p2 * (r2 + 2.0 * x * x),
          y * radial + in.p1 * (r2 + 2.0 * y * y) + 2.0 * in.p2 * x * y};
}

}  // namespace

std::string problem_with(const DepthIntrinsics& in) {
  const auto finite = [](double value) { return std::isfinite(value); };
  if (!(finite(in.fx_px) && finite(in.fy_px) && finite(in.cx_px) && finite(in.cy_px) && finite(in.k1) &&
        finite(in.k2) && finite(in.k3) && finite(in.p1) && finite(in.p2)))
    return "holds a number that is not finite";
  if (in.width_px < 16 || in.height_px < 16 || in.width_px > 8192 || in.height_px > 8192)
    return "has an image size outside 16 to 8192 pixels";
  const double width = in.width_px;
  if (in.fx_px < 0.3 * width || in.fx_px > 3.0 * width || in.fy_px < 0.3 * width || in.fy_px > 3.0 * width)
    return "has a focal length outside 0.3 to 3 image widths";
  if (in.cx_px < 0.25 * width || in.cx_px > 0.75 * width || in.cy_px < 0.25 * in.height_px ||
      in.cy_px > 0.75 * in.height_px)
    return "has a principal point outside the middle half of the image";
  if (std::abs(in.k1) > 2.0 || std::abs(in.k2) > 4.0 || std::abs(in.k3) > 4.0 || std::abs(in.p1) > 0.1 ||
      std::abs(in.p2) > 0.1)
    return "has a distortion coefficient far beyond that of any lens";
  return {};
}

std::optional<std::string> doubt_about(const DepthIntrinsics& in) {
  constexpr DepthIntrinsics kKinect;
  constexpr double kMinFocal_px = 340.0, kMaxFocal_px = 390.0, kMinColour_px = 1000.0, kMaxColour_px = 1150.0;
  if (in.width_px != kKinect.width_px || in.height_px != kKinect.height_px) return std::nullopt;
  const bool fx_is_odd = in.fx_px < kMinFocal_px || in.fx_px > kMaxFocal_px;
  const double odd_px = fx_is_odd ? in.fx_px : in.fy_px;
  if (!fx_is_odd && in.fy_px >= kMinFocal_px && in.fy_px <= kMaxFocal_px) return std::nullopt;
  return "has a focal length of " + std::to_string(std::lround(odd_px)) +
         " px, where depth cameras of a Kinect v2 have about 365" +
         (odd_px > kMinColour_px && odd_px < kMaxColour_px ? ": it is that of its colour camera" : "");
}

std::optional<Eigen::Vector2d> project(const DepthIntrinsics& in, const Eigen::Vector3d& point_in_sensor_m) {
  if (!(point_in_sensor_m.z() > 0.0)) return std::nullopt;
  const Eigen::Vector2d normalised(point_in_sensor_m.x() / point_in_sensor_m.z(),
                                   -point_in_sensor_m.y() / point_in_sensor_m.z());
  if (!(normalised.norm() <= kMaxNormalisedRadius)) return std::nullopt;
  const Eigen::Vector2d distorted = distort(in, normalised, nullptr);
  return Eigen::Vector2d(in.cx_px + in.fx_px * distorted.x(), in.cy_px + in.fy_px * distorted.y());
}

std::optional<Eigen::Vector2d> ray_through(const DepthIntrinsics& in, const Eigen::Vector2d& pixel_px) {
  const Eigen::Vector2d target((pixel_px.x() - in.cx_px) / in.fx_px, (pixel_px.y() - in.cy_px) / in.fy_px);
  Eigen::Vector2d normalised = target;
  for (int step = 0; step < 50; ++step) {
    Eigen::Matrix2d jacobian;
    const Eigen::Vector2d residual = distort(in, normalised, &jacobian) - target;
    normalised -= jacobian.inverse() * residual;
    if (!(normalised.norm() <= kMaxNormalisedRadius)) return std::nullopt;
    if (residual.norm() < 1e-13) return Eigen::Vector2d(normalised.x(), -normalised.y());
  }
  return std::nullopt;
}

Eigen::Vector3d printed_linear_angle_point(const Eigen::Vector2d& pixel_px, double depth_m) {
  return {depth_m * std::tan(70.0 * kRadPerDegree * (pixel_px.x() - 256.0) / 512.0),
          depth_m * std::tan(60.0 * kRadPerDegree * (pixel_px.y() - 212.0) / 424.0), depth_m};
}

}  // namespace trilat
