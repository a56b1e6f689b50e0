// SPDX-License-Identifier: MIT
#include "datasets/rig/rigid_transform.h"

#include <cmath>

#include "datasets/base/error.h"

namespace trilat {

RigidTransform world_from_sensor_looking_at(const Eigen::Vector3d& position_m,
                                            const Eigen::Vector3d& target_m) {
  const Eigen::Vector3d view = target_m - position_m;
  const Eigen::Vector3d left = Eigen::Vector3d::UnitY().cross(view);
  TRILAT_CHECK(left.norm() > 1e-9, "a sensor looks somewhere, and not straight up or down");
  Eigen::Matrix3d axes;
  axes.col(2) = view.normalized();
  axes.col(0) = left.normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return {Eigen::Quaterniond(axes).normalized(), position_m};
}

}  // namespace trilat
