// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace trilat {

// A rotation followed by a translation, named by the frames it connects: `world_from_sensor` turns a point
// given in the sensor's frame into the same point given in the world's. Metres.
struct RigidTransform {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& point_m) const {
    return rotation * point_m + translation_m;
  }
  // c_from_b * b_from_a = c_from_a.
  RigidTransform operator*(const RigidTransform& other) const {
    return {(rotation * other.rotation).normalized(), rotation * other.translation_m + translation_m};
  }
  RigidTransform inverse() const {
    const Eigen::Quaterniond back = rotation.conjugate();
    return {back, -(back * translation_m)};
  }

  // In a document a list of numbers: the quaternion's w, x, y, z, and metres.
  static constexpr bool kIsList = true;
  static void fields(auto& self, auto&& f) {
    auto &q = self.rotation.coeffs(), &p = self.translation_m;
    f("w", q[3], "qx", q[0], "qy", q[1], "qz", q[2], "x", p[0], "y", p[1], "z", p[2]);
  }
};

// A sensor at `position_m` that looks at `target_m` with its y axis as near to world up (+y) as can be. World
// and sensor frames as in frames.h. InternalError when the view is vertical or the points coincide.
RigidTransform world_from_sensor_looking_at(const Eigen::Vector3d& position_m,
                                            const Eigen::Vector3d& target_m);

}  // namespace trilat
