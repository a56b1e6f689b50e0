// SPDX-License-Identifier: MIT
#include "evaluators/fusion/motion_filter.h"

#include <Eigen/LU>

#include "datasets/base/error.h"

namespace trilat {
namespace {

// F = [I dt; 0 I]: the state after dt without acceleration.
Vector6 moved_on(const Vector6& state, double step_s) {
  Vector6 next = state;
  next.head<3>() += step_s * state.tail<3>();
  return next;
}

// F^T state.
Vector6 moved_back(const Vector6& state, double step_s) {
  Vector6 before = state;
  before.tail<3>() += step_s * state.head<3>();
  return before;
}

// F covariance F^T.
Matrix6 moved_on(const Matrix6& covariance, double step_s) {
  Matrix6 next = covariance;
  next.topRows<3>() += step_s * covariance.bottomRows<3>();
  next.leftCols<3>() += step_s * next.rightCols<3>().eval();
  return next;
}

// F^T information F.
Matrix6 moved_back(const Matrix6& information, double step_s) {
  Matrix6 before = information;
  before.bottomRows<3>() += step_s * information.topRows<3>();
  before.rightCols<3>() += step_s * before.leftCols<3>().eval();
  return before;
}

}  // namespace

MotionState MotionState::at(const Eigen::Vector3d& position_m, double position_variance_m2,
                            double speed_variance_m2_s2) {
  MotionState state;
  state.mean.head<3>() = position_m;
  state.covariance.diagonal() << Eigen::Vector3d::Constant(position_variance_m2),
      Eigen::Vector3d::Constant(speed_variance_m2_s2);
  return state;
}

void MotionFilter::begin(const MotionState& first) {
  now_ = first;
  steps_.assign(1, {});
  steps_[0].predicted = first;
}

void MotionFilter::predict(double step_s) {
  TRILAT_CHECK(!steps_.empty(), "a filter begins before it predicts");
  now_ = {moved_on(now_.mean, step_s), moved_on(now_.covariance, step_s)};
  const double velocity = density_ * step_s, both = velocity * step_s / 2.0, position = both * step_s / 1.5;
  now_.covariance.diagonal().head<3>().array() += position;
  now_.covariance.diagonal().tail<3>().array() += velocity;
  now_.covariance.topRightCorner<3, 3>().diagonal().array() += both;
  now_.covariance.bottomLeftCorner<3, 3>().diagonal().array() += both;
  if (!keeps_all_) steps_.clear();
  steps_.push_back({step_s, now_});
}

void MotionFilter::update(const PositionInformation& measured) {
  FilterStep& step = steps_.back();
  const Matrix6& p = step.predicted.covariance;
  const Eigen::Matrix3d inverse =
      (Eigen::Matrix3d::Identity() + measured.matrix * p.topLeftCorner<3, 3>()).inverse();
  step.gain = inverse * measured.matrix;
  step.influence = inverse * (measured.vector - measured.matrix * step.predicted.mean.head<3>());
  now_.mean = step.predicted.mean + p.leftCols<3>() * step.influence;
  now_.covariance = p - p.leftCols<3>() * (step.gain * p.topRows<3>());
}

// The adjoint is what later instants say of the predicted state: smoothed = predicted + P adjoint, and its
// information takes P information P off P.
void MotionFilter::smooth(std::size_t instants, bool with_covariances,
                          const std::function<void(std::size_t, const MotionState&)>& visit) const {
  TRILAT_CHECK(keeps_all_ && instants <= steps_.size(), "only instants of the filter are smoothed");
  Vector6 adjoint = Vector6::Zero();
  Matrix6 information = Matrix6::Zero();
  for (std::size_t i = instants; i-- > 0;) {
    const FilterStep& step = steps_[i];
    const Matrix6& p = step.predicted.covariance;
    adjoint.head<3>() += step.influence - step.gain * (p.topRows<3>() * adjoint);
    MotionState state{step.predicted.mean + p * adjoint, Matrix6::Zero()};
    if (with_covariances) {
      Matrix6 rest = Matrix6::Identity();  // I - P E G E^T
      rest.leftCols<3>() -= p.leftCols<3>() * step.gain;
      information = (rest.transpose() * information * rest).eval();
      information.topLeftCorner<3, 3>() += step.gain;
      state.covariance = p - p * information * p;
      information = moved_back(information, step.step_s);
    }
    visit(i, state);
    adjoint = moved_back(adjoint, step.step_s);
  }
}

}  // namespace trilat
