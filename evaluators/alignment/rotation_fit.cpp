// SPDX-License-Identifier: MIT
#include "evaluators/alignment/rotation_fit.h"

#include <Eigen/LU>
#include <Eigen/SVD>

namespace trilat {

RotationFit fit_rotation(const Eigen::Matrix3d& cross) {
  constexpr double kDegenerateRatio = 1e-9;
  RotationFit fit;
  if (!cross.allFinite()) return fit;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d &u = svd.matrixU(), &v = svd.matrixV();
  const Eigen::Vector3d& s = svd.singularValues();
  const double sign = u.determinant() * v.determinant() < 0.0 ? -1.0 : 1.0;
  fit.b_from_a = u * Eigen::Vector3d(1.0, 1.0, sign).asDiagonal() * v.transpose();
  fit.mirrored_b_from_a = u * Eigen::Vector3d(1.0, 1.0, -sign).asDiagonal() * v.transpose();
  fit.trace = s[0] + s[1] + sign * s[2];
  fit.mirrored_trace = s[0] + s[1] - sign * s[2];
  fit.is_determined = 2.0 * (s[1] + sign * s[2]) > kDegenerateRatio * fit.trace;
  return fit;
}

}  // namespace trilat
