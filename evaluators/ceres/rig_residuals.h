// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

// The terms of refine_rig()'s cost, for automatic derivatives.
namespace trilat {

// What a unit's depth may be off by: a constant, and waves of some lengths, each as cosine and sine.
inline constexpr int kDepthWaves = 12;
inline constexpr int kDepthTerms = 1 + 2 * kDepthWaves;

// Whitened distance of a point from its observation, in the sensor's frame, less what the depth is off by.
struct PointResidual {
  Eigen::Vector3d measured_m;
  Eigen::Matrix3d whitening;
  Eigen::Matrix<double, 3, kDepthTerms> by_term;  // how the measured point moves with each term

  template <class T>
  void whitened(const T* rotation, const T* position, const T* point, const T* terms_m, T* out) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Eigen::Quaternion<T>> q(rotation);
    const Vector in_world = Eigen::Map<const Vector>(point) - Eigen::Map<const Vector>(position);
    Vector off = q.conjugate() * in_world - measured_m.cast<T>();
    if (terms_m) off += by_term.cast<T>() * Eigen::Map<const Eigen::Matrix<T, kDepthTerms, 1>>(terms_m);
    Eigen::Map<Vector> residual(out);
    residual = whitening.cast<T>() * off;
  }
  template <class T>
  bool operator()(const T* rotation, const T* position, const T* point, T* out) const {
    whitened(rotation, position, point, static_cast<const T*>(nullptr), out);
    return true;
  }
  template <class T>
  bool operator()(const T* rotation, const T* position, const T* point, const T* terms_m, T* out) const {
    whitened(rotation, position, point, terms_m, out);
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
