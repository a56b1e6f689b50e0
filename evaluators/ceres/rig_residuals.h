// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

// The terms of refine_rig()'s cost, for automatic derivatives.
namespace trilat {

// Whitened distance of a point from its observation, in the sensor's frame, the measured depth corrected
// along the ray by offset + wiggle.
struct PointResidual {
  Eigen::Vector3d measured_m, along_ray;  // the ray scaled to z = 1
  Eigen::Matrix3d whitening;
  double share_b = 0.0;  // of the second knot

  template <class T>
  void whitened(const T* rotation, const T* position, const T* point, const T& correction_m, T* out) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Eigen::Quaternion<T>> q(rotation);
    const Vector in_world = Eigen::Map<const Vector>(point) - Eigen::Map<const Vector>(position);
    const Vector expected = q.conjugate() * in_world;
    const Vector corrected = measured_m.cast<T>() - correction_m * along_ray.cast<T>();
    Eigen::Map<Vector> residual(out);
    residual = whitening.cast<T>() * (expected - corrected);
  }
  template <class T>
  bool operator()(const T* rotation, const T* position, const T* point, T* out) const {
    whitened(rotation, position, point, T(0), out);
    return true;
  }
  template <class T>
  bool operator()(const T* rotation, const T* position, const T* point, const T* offset, const T* knot_a,
                  const T* knot_b, T* out) const {
    whitened(rotation, position, point, offset[0] + (1.0 - share_b) * knot_a[0] + share_b * knot_b[0], out);
    return true;
  }
};

struct Prior {
  double weight = 1.0;
  template <class T>
  bool operator()(const T* value, T* out) const {
    out[0] = weight * value[0];
    return true;
  }
};

struct KnownResidual {
  Eigen::Vector3d known_m;
  double weight = 1.0;
  template <class T>
  bool operator()(const T* point, T* out) const {
    for (int axis = 0; axis < 3; ++axis) out[axis] = weight * (point[axis] - known_m[axis]);
    return true;
  }
};

// Of the gauge's second point, which lies on the x axis.
struct DistanceResidual {
  double distance_m = 0.0, weight = 1.0;
  template <class T>
  bool operator()(const T* point, T* out) const {
    out[0] = weight * (point[0] - distance_m);
    return true;
  }
};

}  // namespace trilat
