// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "evaluators/fusion/joint_observation.h"
#include "evaluators/solvers/point_estimate.h"

namespace trilat {

// One joint's path over time from the positions all sensors give: a joint that moves with a velocity driven
// by white acceleration, the same in every direction. The filter uses what was seen until the instant, the
// smoother (Rauch, Tung and Striebel 1965) the whole path.
struct KalmanOptions {
  SensorMask allowed = kAllSensors;
  double sigma_m = 0.03;         // of one tracked position, per axis
  double inferred_factor = 3.0;  // on it when the joint is inferred
  // Spectral density of the acceleration: limbs of 5 m/s^2 that keep their acceleration for 0.1 s make about
  // 5^2 x 2 x 0.1.
  double acceleration_density_m2_s3 = 5.0;
  double speed_sigma_m_s = 2.0;  // of a joint that was not seen before, per axis
  // A position is left out that lies as unlikely far from the prediction as a number so many standard
  // deviations off (chi-square of three degrees of freedom).
  double gate_sigma = 5.0;
  // How long the path goes on without an accepted position; then it ends, and the next position starts anew.
  double longest_gap_s = 0.215;
  bool smooth = false;
};

// Observations of one joint over time.
struct JointPath {
  std::span<const std::int64_t> time_ns;  // must rise
  std::size_t sensors = 0;
  // Says what every sensor of the rig sees of it at an instant. Positions that are not finite count as not
  // seen.
  std::function<void(std::size_t instant, std::span<JointObservation> observations)> observe;
};

// One estimate an instant: closed_form with `covariance` of the position, or no_observation where no path is:
// before the first position, in a gap longer than longest_gap_s; the smoother also not behind the last
// position. non_finite_input is not met.
[[nodiscard]] std::vector<PointEstimate> solve_kalman(const JointPath& path, const KalmanOptions& options);

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

// A point's position (m) and velocity (m/s), one behind the other.
struct MotionState {
  Vector6 mean = Vector6::Zero();
  Matrix6 covariance = Matrix6::Zero();

  // Known to `position_variance_m2` an axis and at rest to `speed_variance_m2_s2`.
  static MotionState at(const Eigen::Vector3d& position_m, double position_variance_m2,
                        double speed_variance_m2_s2);
};

// Measurements of a position x at one instant: x^T matrix x - 2 x^T vector, the sum of squared residuals
// in sigmas but for a constant.
struct PositionInformation {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d vector = Eigen::Vector3d::Zero();

  void add_point(const Eigen::Vector3d& point_m, double weight_1_m2) {
    matrix.diagonal().array() += weight_1_m2;
    vector += weight_1_m2 * point_m;
  }
  // Adds that the position lies `along_m` from the origin in a direction of length 1.
  void add_distance(const Eigen::Vector3d& direction, double along_m, double weight_1_m2) {
    matrix += weight_1_m2 * direction * direction.transpose();
    vector += weight_1_m2 * along_m * direction;
  }
};

// Kalman's filter of a point whose velocity is driven by white acceleration, the same in every direction: a
// step of dt adds q [dt^3/3 dt^2/2; dt^2/2 dt] an axis. What the backward pass needs is some 450 bytes an
// instant; without smoothing only the last instant is kept.
class MotionFilter {
 public:
  // `smoothed`: the most instants from one begin() to the next that smooth() is called for; 0: never.
  MotionFilter(double acceleration_density_m2_s3, std::size_t smoothed)
      : density_(acceleration_density_m2_s3), keeps_all_(smoothed > 0) {
    steps_.reserve(smoothed);
  }

  void begin(const MotionState& first);              // forgets all before
  void predict(double step_s);                       // the next instant
  void update(const PositionInformation& measured);  // of the last instant, at most once
  const MotionState& now() const { return now_; }    // of the last instant

  // Visits the states of the first so many instants since begin(), from the last to the first, given all that
  // was measured until the last of them, by the fixed-interval smoother of Bryson and Frazier (1963), which
  // inverts no covariance. They are what the smoother of Rauch, Tung and Striebel (1965) gives. Covariances
  // are zero unless they are wanted.
  void smooth(std::size_t instants, bool with_covariances,
              const std::function<void(std::size_t instant, const MotionState& state)>& visit) const;

 private:
  struct FilterStep {
    double step_s = 0.0;  // from the instant before
    MotionState predicted;
    Eigen::Matrix3d gain = Eigen::Matrix3d::Zero();       // A (I + P A)^-1 of A measured, P predicted
    Eigen::Vector3d influence = Eigen::Vector3d::Zero();  // (I + A P)^-1 (b - A x)
  };

  double density_;
  bool keeps_all_;
  MotionState now_;
  std::vector<FilterStep> steps_;
};

}  // namespace trilat
