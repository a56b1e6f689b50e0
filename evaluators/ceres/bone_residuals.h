// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

#include <Eigen/Core>
#include <ceres/sized_cost_function.h>

// The terms of solve_bone_window()'s cost. An unknown is a joint's position (m) and velocity (m/s) at one
// instant. Derivatives by hand: a window has thousands of terms.
namespace trilat {

using PathUnknown = Eigen::Matrix<double, 6, 1>;  // position, velocity

// (part of the unknown - value) / sigma: an observed position, or what is known of a velocity beforehand.
class ValueResidual final : public ceres::SizedCostFunction<3, 6> {
 public:
  enum class Part { position = 0, velocity = 3 };
  ValueResidual(Part part, const Eigen::Vector3d& value, double sigma)
      : first_(static_cast<int>(part)), value_(value), scale_(1.0 / sigma) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    for (int axis = 0; axis < 3; ++axis)
      residuals[axis] = scale_ * (parameters[0][first_ + axis] - value_[axis]);
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    Eigen::Map<Eigen::Matrix<double, 3, 6, Eigen::RowMajor>> jacobian(jacobians[0]);
    jacobian.setZero();
    for (int axis = 0; axis < 3; ++axis) jacobian(axis, first_ + axis) = scale_;
    return true;
  }

 private:
  int first_;
  Eigen::Vector3d value_;
  double scale_;
};

// From one instant to the next: L^-1 (later - predicted), where L L^T = q [dt^3/3 dt^2/2; dt^2/2 dt] is the
// covariance of a step driven by white acceleration of spectral density q.
class MotionResidual final : public ceres::SizedCostFunction<6, 6, 6> {
 public:
  MotionResidual(double step_s, double density_m2_s3)
      : step_s_(step_s),
        position_scale_(std::sqrt(3.0 / (density_m2_s3 * step_s)) / step_s),
        velocity_scale_(2.0 / std::sqrt(density_m2_s3 * step_s)) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const double *before = parameters[0], *after = parameters[1];
    // The second row of L^-1 is (-3 / dt, 2) / sqrt(q dt).
    const double mixed = -1.5 / step_s_ * velocity_scale_;
    for (int axis = 0; axis < 3; ++axis) {
      const double position_m = after[axis] - before[axis] - step_s_ * before[axis + 3];
      const double velocity_m_s = after[axis + 3] - before[axis + 3];
      residuals[axis] = position_scale_ * position_m;
      residuals[axis + 3] = mixed * position_m + velocity_scale_ * velocity_m_s;
    }
    if (jacobians == nullptr) return true;
    using Jacobian = Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>;
    for (int side = 0; side < 2; ++side) {
      if (jacobians[side] == nullptr) continue;
      Jacobian jacobian(jacobians[side]);
      jacobian.setZero();
      const double sign = side == 0 ? -1.0 : 1.0;
      for (int axis = 0; axis < 3; ++axis) {
        jacobian(axis, axis) = sign * position_scale_;
        jacobian(axis + 3, axis) = sign * mixed;
        jacobian(axis + 3, axis + 3) = sign * velocity_scale_;
        if (side == 1) continue;
        jacobian(axis, axis + 3) = -step_s_ * position_scale_;
        jacobian(axis + 3, axis + 3) -= step_s_ * mixed;
      }
    }
    return true;
  }

 private:
  double step_s_, position_scale_, velocity_scale_;
};

// (|child - parent| - length) / sigma.
class BoneResidual final : public ceres::SizedCostFunction<1, 6, 6> {
 public:
  BoneResidual(double length_m, double sigma_m) : length_m_(length_m), scale_(1.0 / sigma_m) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    using Position = Eigen::Map<const Eigen::Vector3d>;
    const Eigen::Vector3d along_m = Position(parameters[1]) - Position(parameters[0]);
    const double distance_m = along_m.norm();
    residuals[0] = scale_ * (distance_m - length_m_);
    if (jacobians == nullptr) return true;
    // Joints in one place have no direction.
    const double factor = distance_m > 1e-12 ? scale_ / distance_m : 0.0;
    for (int side = 0; side < 2; ++side) {
      if (jacobians[side] == nullptr) continue;
      Eigen::Map<PathUnknown> row(jacobians[side]);
      row.head<3>() = (side == 0 ? -factor : factor) * along_m;
      row.tail<3>().setZero();
    }
    return true;
  }

 private:
  double length_m_, scale_;
};

}  // namespace trilat
