// SPDX-License-Identifier: MIT
#include "datasets/rig/depth_rays.h"

#include <limits>

namespace trilat {

DepthRays depth_rays(const DepthIntrinsics& intrinsics) {
  const std::size_t pixels =
      static_cast<std::size_t>(intrinsics.width_px) * static_cast<std::size_t>(intrinsics.height_px);
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  DepthRays rays{intrinsics, std::vector<float>(pixels, kNone), std::vector<float>(pixels, kNone)};
  for (int row = 0; row < intrinsics.height_px; ++row)
    for (int column = 0; column < intrinsics.width_px; ++column)
      if (const auto ray = ray_through(intrinsics, Eigen::Vector2d(column, row))) {
        rays.x[rays.index(column, row)] = static_cast<float>(ray->x());
        rays.y[rays.index(column, row)] = static_cast<float>(ray->y());
      }
  return rays;
}

}  // namespace trilat
