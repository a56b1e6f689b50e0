// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>

#include <Eigen/Core>

#include "evaluators/solvers/point_estimate.h"

namespace trilat {

// The body's own frame stands upright: x to the body's left, y up, z forward. `heading_rad` turns forward
// from world +z towards +x, as in SkeletonPose.
inline Eigen::Matrix3d world_from_body(double heading_rad) {
  const double c = std::cos(heading_rad), s = std::sin(heading_rad);
  return (Eigen::Matrix3d() << c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c).finished();
}

// The mean error of one joint in the body's own frame: a tracker's joint and the middle of the markers are
// not the same point of the body, and that difference turns with the body.
class JointOffset {
 public:
  void add(const Eigen::Vector3d& estimate_m, const Eigen::Vector3d& truth_m, double heading_rad) {
    ++count_;
    mean_in_body_m_ += (world_from_body(heading_rad).transpose() * (estimate_m - truth_m) - mean_in_body_m_) /
                       static_cast<double>(count_);
  }
  std::int64_t count() const { return count_; }
  // NaN when nothing was added.
  Eigen::Vector3d in_body_m() const { return count_ > 0 ? mean_in_body_m_ : Eigen::Vector3d::Constant(kNaN); }
  Eigen::Vector3d corrected(const Eigen::Vector3d& estimate_m, double heading_rad) const {
    return estimate_m - world_from_body(heading_rad) * in_body_m();
  }
  // Shows all that `offset` consists of to see(number), which may change it: to store it and bring it back.
  template <class Offset, class See>
  static void see_state(Offset& offset, const See& see) {
    see(offset.count_);
    for (int axis = 0; axis < 3; ++axis) see(offset.mean_in_body_m_[axis]);
  }

 private:
  std::int64_t count_ = 0;
  Eigen::Vector3d mean_in_body_m_ = Eigen::Vector3d::Zero();
};

}  // namespace trilat
