// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include <Eigen/Core>

#include "datasets/geometry/rigid_transform.h"
#include "evaluators/solvers/point_estimate.h"

namespace trilat {

// How two weighted sets of points fit each other: least squares of b - (scale R a + t), Umeyama 1991.
struct PointFit {
  RigidTransform b_from_a;       // without the scale: R, and the t of scale 1
  double scale = kNaN;           // of b over a
  double rms_m = kNaN;           // of what the rotation and translation leave, scale 1
  double mirrored_rms_m = kNaN;  // and of what they leave when one set is mirrored first
};

// Points of equal number, in metres; those that are not finite are left out. NaN for fewer than three.
[[nodiscard]] PointFit fit_points(std::span<const Eigen::Vector3d> a, std::span<const Eigen::Vector3d> b,
                                  std::span<const double> weight);
[[nodiscard]] PointFit fit_points(std::span<const Eigen::Vector3d> a, std::span<const Eigen::Vector3d> b);

}  // namespace trilat
