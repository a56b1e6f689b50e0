// SPDX-License-Identifier: MIT
#include "evaluators/fusion/kalman.h"

#include <array>

#include "datasets/base/error.h"
#include "evaluators/metrics/student.h"

namespace trilat {
namespace {

// Position and velocity of the three axes, which share one covariance because all noise is isotropic.
struct PathState {
  Eigen::Matrix<double, 2, 3> mean = Eigen::Matrix<double, 2, 3>::Zero();  // rows: position, velocity
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
};

Eigen::Matrix2d transition(double step_s) { return (Eigen::Matrix2d() << 1.0, step_s, 0.0, 1.0).finished(); }

PathState predict(const PathState& state, double step_s, double density) {
  const Eigen::Matrix2d f = transition(step_s);
  PathState next{f * state.mean, f * state.covariance * f.transpose()};
  const double s2 = step_s * step_s;
  next.covariance +=
      density * (Eigen::Matrix2d() << s2 * step_s / 3.0, s2 / 2.0, s2 / 2.0, step_s).finished();
  return next;
}

double variance_of(const JointObservation& o, const KalmanOptions& options) {
  const double sigma_m =
      options.sigma_m * (o.state == TrackingState::tracked ? 1.0 : options.inferred_factor);
  return sigma_m * sigma_m;
}

bool is_allowed(const JointObservation& o, std::size_t sensor, const KalmanOptions& options) {
  return options.allowed[sensor] && o.seen && o.point_in_world_m.allFinite();
}

// Takes in one instant's positions one after the other; false when all were refused or none was there.
// `gate`: of squared distances, in variances.
bool update(PathState& state, std::span<const JointObservation> instant, const KalmanOptions& options,
            double gate) {
  const double predicted_variance = state.covariance(0, 0);
  const Eigen::RowVector3d predicted = state.mean.row(0);
  bool accepted = false;
  for (std::size_t s = 0; s < instant.size(); ++s) {
    if (!is_allowed(instant[s], s, options)) continue;
    const double variance = variance_of(instant[s], options);
    const Eigen::RowVector3d point = instant[s].point_in_world_m.transpose();
    // against the prediction, so that the order of the sensors does not matter
    if ((point - predicted).squaredNorm() > gate * (predicted_variance + variance)) continue;
    const Eigen::Vector2d gain = state.covariance.col(0) / (state.covariance(0, 0) + variance);
    state.mean += gain * (point - state.mean.row(0));
    state.covariance -= (gain * state.covariance.row(0)).eval();
    accepted = true;
  }
  return accepted;
}

bool start(PathState& state, std::span<const JointObservation> instant, const KalmanOptions& options) {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  double weights = 0.0;
  for (std::size_t s = 0; s < instant.size(); ++s) {
    if (!is_allowed(instant[s], s, options)) continue;
    const double weight = 1.0 / variance_of(instant[s], options);
    sum_m += weight * instant[s].point_in_world_m;
    weights += weight;
  }
  if (weights == 0.0) return false;
  state.mean.setZero();
  state.mean.row(0) = (sum_m / weights).transpose();
  state.covariance << 1.0 / weights, 0.0, 0.0, options.speed_sigma_m_s * options.speed_sigma_m_s;
  return true;
}

PointEstimate estimate_of(const PathState& state) {
  PointEstimate estimate;
  estimate.position_m = state.mean.row(0).transpose();
  estimate.status = SolveStatus::closed_form;
  estimate.covariance = state.covariance(0, 0) * Eigen::Matrix3d::Identity();
  return estimate;
}

class Path {
 public:
  Path(std::span<const std::int64_t> time_ns, const KalmanOptions& options,
       std::span<PointEstimate> estimates)
      : time_ns_(time_ns),
        options_(options),
        estimates_(estimates),
        gate_(chi_square_limit(options.gate_sigma, 3.0)) {}

  void add(std::size_t i, std::span<const JointObservation> instant) {
    estimates_[i] = failed_estimate(SolveStatus::no_observation);
    if (!running_) {
      begin(i, instant);
      return;
    }
    PathState state = predicted(filtered_.back(), i);
    if (update(state, instant, options_, gate_)) {
      last_seen_ = i;
    } else if (seconds(last_seen_, i) > options_.longest_gap_s) {
      end();
      begin(i, instant);
      return;
    }
    keep(i, state);
  }

  // Smooths from the first to the last position of the path.
  void end() {
    if (running_ && options_.smooth) {
      PathState later = filtered_[last_seen_ - first_];
      estimates_[last_seen_] = estimate_of(later);
      for (std::size_t k = last_seen_ - first_; k-- > 0;) {
        const PathState& filtered = filtered_[k];
        const PathState prediction = predicted(filtered, first_ + k + 1);
        const Eigen::Matrix2d gain = filtered.covariance * transition(step_s(first_ + k + 1)).transpose() *
                                     prediction.covariance.inverse();
        later = {filtered.mean + gain * (later.mean - prediction.mean),
                 filtered.covariance + gain * (later.covariance - prediction.covariance) * gain.transpose()};
        estimates_[first_ + k] = estimate_of(later);
      }
    }
    running_ = false;
  }

 private:
  void begin(std::size_t i, std::span<const JointObservation> instant) {
    PathState state;
    if (!start(state, instant, options_)) return;
    running_ = true;
    first_ = last_seen_ = i;
    filtered_.clear();
    keep(i, state);
  }
  // The filter needs no state but the last.
  void keep(std::size_t i, const PathState& state) {
    if (!options_.smooth) {
      filtered_.clear();
      estimates_[i] = estimate_of(state);
    }
    filtered_.push_back(state);
  }
  // At instant i, from the state at the one before.
  PathState predicted(const PathState& before, std::size_t i) const {
    return predict(before, step_s(i), options_.acceleration_density_m2_s3);
  }
  double seconds(std::size_t from, std::size_t to) const {
    return static_cast<double>(time_ns_[to] - time_ns_[from]) * 1e-9;
  }
  double step_s(std::size_t i) const { return seconds(i - 1, i); }

  std::span<const std::int64_t> time_ns_;
  const KalmanOptions& options_;
  std::span<PointEstimate> estimates_;
  double gate_;
  bool running_ = false;
  std::size_t first_ = 0, last_seen_ = 0;
  std::vector<PathState> filtered_;  // the smoother's from first_ on
};

}  // namespace

std::vector<PointEstimate> solve_kalman(const JointPath& path, const KalmanOptions& options) {
  TRILAT_CHECK(path.sensors <= kMaxSensors, "a rig has at most kMaxSensors sensors");
  std::vector<PointEstimate> estimates(path.time_ns.size());
  Path course(path.time_ns, options, estimates);
  std::array<JointObservation, kMaxSensors> instant;
  const std::span<JointObservation> seen(instant.data(), path.sensors);
  for (std::size_t i = 0; i < path.time_ns.size(); ++i) {
    path.observe(i, seen);
    course.add(i, seen);
  }
  course.end();
  return estimates;
}

}  // namespace trilat
