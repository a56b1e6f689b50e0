// SPDX-License-Identifier: MIT
#include "evaluators/fusion/kalman.h"

#include <array>

#include <Eigen/LU>

#include "datasets/base/error.h"
#include "evaluators/metrics/statistics.h"

namespace trilat {
namespace {

double variance_of(const JointObservation& o, const KalmanOptions& options) {
  const double sigma_m =
      options.sigma_m * (o.state == TrackingState::tracked ? 1.0 : options.inferred_factor);
  return sigma_m * sigma_m;
}

bool is_allowed(const JointObservation& o, std::size_t sensor, const KalmanOptions& options) {
  return options.allowed[sensor] && o.seen && o.point_in_world_m.allFinite();
}

PointEstimate estimate_of(const MotionState& state) {
  PointEstimate estimate;
  estimate.position_m = state.mean.head<3>();
  estimate.status = SolveStatus::closed_form;
  estimate.covariance = state.covariance.topLeftCorner<3, 3>();
  return estimate;
}

class FilteredPath {
 public:
  FilteredPath(std::span<const std::int64_t> time_ns, const KalmanOptions& options,
               std::span<PointEstimate> estimates)
      : time_ns_(time_ns),
        options_(options),
        estimates_(estimates),
        gate_(chi_square_limit(options.gate_sigma, 3.0)),
        filter_(options.acceleration_density_m2_s3, options.smooth ? time_ns.size() : 0) {}

  void add(std::size_t i, std::span<const JointObservation> instant) {
    estimates_[i] = failed_estimate(SolveStatus::no_observation);
    if (!running_) return begin(i, instant);
    filter_.predict(seconds(i - 1, i));
    const PositionInformation measured = accepted(instant);
    if (measured.matrix(0, 0) > 0.0) {
      filter_.update(measured);
      last_seen_ = i;
    } else if (seconds(last_seen_, i) > options_.longest_gap_s) {
      end();
      return begin(i, instant);
    }
    if (!options_.smooth) estimates_[i] = estimate_of(filter_.now());
  }

  // Smooths from the first to the last position of the path.
  void end() {
    if (running_ && options_.smooth)
      filter_.smooth(last_seen_ - first_ + 1, true, [&](std::size_t k, const MotionState& state) {
        estimates_[first_ + k] = estimate_of(state);
      });
    running_ = false;
  }

 private:
  void begin(std::size_t i, std::span<const JointObservation> instant) {
    PositionInformation seen;
    for (std::size_t s = 0; s < instant.size(); ++s)
      if (is_allowed(instant[s], s, options_))
        seen.add_point(instant[s].point_in_world_m, 1.0 / variance_of(instant[s], options_));
    const double weight = seen.matrix(0, 0);
    if (weight == 0.0) return;
    running_ = true;
    first_ = last_seen_ = i;
    filter_.begin(MotionState::at(seen.vector / weight, 1.0 / weight,
                                  options_.speed_sigma_m_s * options_.speed_sigma_m_s));
    if (!options_.smooth) estimates_[i] = estimate_of(filter_.now());
  }

  // Positions within the gate around the prediction; the order of the sensors does not matter.
  PositionInformation accepted(std::span<const JointObservation> instant) const {
    PositionInformation measured;
    for (std::size_t s = 0; s < instant.size(); ++s) {
      if (!is_allowed(instant[s], s, options_)) continue;
      const double variance = variance_of(instant[s], options_);
      const double off_m2 = (instant[s].point_in_world_m - filter_.now().mean.head<3>()).squaredNorm();
      if (off_m2 <= gate_ * (filter_.now().covariance(0, 0) + variance))
        measured.add_point(instant[s].point_in_world_m, 1.0 / variance);
    }
    return measured;
  }
  double seconds(std::size_t from, std::size_t to) const {
    return static_cast<double>(time_ns_[to] - time_ns_[from]) * 1e-9;
  }

  std::span<const std::int64_t> time_ns_;
  const KalmanOptions& options_;
  std::span<PointEstimate> estimates_;
  double gate_;  // of squared distances, in variances
  MotionFilter filter_;
  bool running_ = false;
  std::size_t first_ = 0, last_seen_ = 0;
};

}  // namespace

std::vector<PointEstimate> solve_kalman(const JointPath& path, const KalmanOptions& options) {
  TRILAT_CHECK(path.sensors <= kMaxSensors, "a rig has at most kMaxSensors sensors");
  std::vector<PointEstimate> estimates(path.time_ns.size());
  FilteredPath filtered(path.time_ns, options, estimates);
  std::array<JointObservation, kMaxSensors> instant;
  const std::span<JointObservation> seen(instant.data(), path.sensors);
  for (std::size_t i = 0; i < path.time_ns.size(); ++i) {
    path.observe(i, seen);
    filtered.add(i, seen);
  }
  filtered.end();
  return estimates;
}

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
