// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

namespace trilat {

// A symmetric 3x3 matrix by its upper triangle.
struct Symmetric3 {
  double xx = 0.0, xy = 0.0, xz = 0.0, yy = 0.0, yz = 0.0, zz = 0.0;

  void add_outer(double weight, const Eigen::Vector3d& v) {
    const double wx = weight * v.x();
    const double wy = weight * v.y();
    xx += wx * v.x();
    xy += wx * v.y();
    xz += wx * v.z();
    yy += wy * v.y();
    yz += wy * v.z();
    zz += weight * v.z() * v.z();
  }
  void add_to_diagonal(double value) {
    xx += value;
    yy += value;
    zz += value;
  }
  double trace() const { return xx + yy + zz; }
  // The inverse is adjugate / determinant; the sum of the adjugate's diagonal is the sum of the products of
  // two eigenvalues.
  Symmetric3 adjugate() const {
    return {yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy,
            xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy};
  }
  double determinant(const Symmetric3& adjugate) const {
    return xx * adjugate.xx + xy * adjugate.xy + xz * adjugate.xz;
  }
  Eigen::Vector3d operator*(const Eigen::Vector3d& v) const {
    return {xx * v.x() + xy * v.y() + xz * v.z(), xy * v.x() + yy * v.y() + yz * v.z(),
            xz * v.x() + yz * v.y() + zz * v.z()};
  }
  Eigen::Matrix3d matrix() const {
    Eigen::Matrix3d full;
    full << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    return full;
  }
};

}  // namespace trilat
