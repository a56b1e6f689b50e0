// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "datasets/geometry/rigid_transform.h"

namespace trilat {

// The frame that three places of the wand define (frames.h): origin at the first, x towards the second, the
// third on y's side of the x axis, z across. Nothing when the places coincide (1 cm) or lie nearly on a line
// (the third within 1 % of the first two's distance of their line).
inline std::optional<RigidTransform> wand_from_places(const Eigen::Vector3d& first_m,
                                                      const Eigen::Vector3d& second_m,
                                                      const Eigen::Vector3d& third_m) {
  const Eigen::Vector3d x = second_m - first_m;
  const Eigen::Vector3d z = x.cross(third_m - first_m);
  if (!(x.norm() > 0.01) || !(z.norm() > 0.01 * x.squaredNorm())) return std::nullopt;
  Eigen::Matrix3d axes;
  axes.row(0) = x.normalized();
  axes.row(2) = z.normalized();
  axes.row(1) = axes.row(2).cross(axes.row(0));
  const Eigen::Quaterniond rotation = Eigen::Quaterniond(axes).normalized();
  return RigidTransform{rotation, -(rotation * first_m)};
}

}  // namespace trilat
