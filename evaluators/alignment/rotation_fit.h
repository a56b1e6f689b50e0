// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "evaluators/solvers/point_estimate.h"

namespace trilat {

// The rotation that lays one set of points over another by least squares: it maximises trace(R^T C) of their
// cross-covariance C (Kabsch 1976; Umeyama 1991). The sum of squares that is left falls by twice that trace.
struct RotationFit {
  // False where 2 (s_2 + sign(det C) s_3) <= 1e-9 (s_1 + s_2 + sign(det C) s_3), s the singular values: all
  // points on one line, or one point. Also where C is not finite; then all else is NaN.
  bool is_determined = false;
  Eigen::Matrix3d b_from_a = Eigen::Matrix3d::Constant(kNaN);
  double trace = kNaN;  // of b_from_a^T C
  // The best of the rotations that mirror, and its trace.
  Eigen::Matrix3d mirrored_b_from_a = Eigen::Matrix3d::Constant(kNaN);
  double mirrored_trace = kNaN;
};

// `cross`: the sum of (b - mean)(a - mean)^T, weighted or not, or of b a^T.
[[nodiscard]] RotationFit fit_rotation(const Eigen::Matrix3d& cross);

}  // namespace trilat
