// SPDX-License-Identifier: MIT
#include "evaluators/metrics/joint_angles.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace trilat {
namespace {

// The angle by atan2, which stays exact for nearly parallel vectors; NaN when one of them is zero.
double angle_rad(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const double across = a.cross(b).norm(), along = a.dot(b);
  return across == 0.0 && along == 0.0 ? std::nan("") : std::atan2(across, along);
}

}  // namespace

double flexion_rad(const Eigen::Vector3d& upper_end, const Eigen::Vector3d& joint,
                   const Eigen::Vector3d& lower_end) {
  return std::numbers::pi - angle_rad(upper_end - joint, lower_end - joint);
}

double inclination_rad(const Eigen::Vector3d& below, const Eigen::Vector3d& above) {
  return angle_rad(above - below, Eigen::Vector3d::UnitY());
}

}  // namespace trilat
