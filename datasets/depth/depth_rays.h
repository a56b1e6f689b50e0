// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "datasets/geometry/depth_camera.h"

namespace trilat {

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
