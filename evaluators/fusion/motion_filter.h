// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace trilat {

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

// What is measured of a position x at one instant: x^T matrix x - 2 x^T vector, the sum of squared residuals
// in sigmas but for a constant.
struct PositionInformation {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d vector = Eigen::Vector3d::Zero();

  void add_point(const Eigen::Vector3d& point_m, double weight_1_m2) {
    matrix.diagonal().array() += weight_1_m2;
    vector += weight_1_m2 * point_m;
  }
  // That the position lies `along_m` from the origin in a direction of length 1.
  void add_distance(const Eigen::Vector3d& direction, double along_m, double weight_1_m2) {
    matrix += weight_1_m2 * direction * direction.transpose();
    vector += weight_1_m2 * along_m * direction;
  }
};

// Kalman's filter of a point whose velocity is driven by white acceleration, the same in every direction: a
// step of dt adds q [dt^3/3 dt^2/2; dt^2/2 dt] an axis. Keeps what the backward pass needs: some 450 bytes an
// instant.
class MotionFilter {
 public:
  explicit MotionFilter(double acceleration_density_m2_s3) : density_(acceleration_density_m2_s3) {}

  void begin(const MotionState& first);              // forgets all before
  void predict(double step_s);                       // the next instant
  void update(const PositionInformation& measured);  // of the last instant, at most once
  const MotionState& now() const { return now_; }    // of the last instant
  std::size_t instants() const { return steps_.size(); }

  // The states of the first so many instants since begin(), given all that was measured until the last of
  // them, by the fixed-interval smoother of Bryson and Frazier (1963), which inverts no covariance. They are
  // what the smoother of Rauch, Tung and Striebel (1965) gives.
  std::vector<MotionState> smoothed(std::size_t instants) const;
  std::vector<Eigen::Vector3d> smoothed_positions_m(std::size_t instants) const;

 private:
  struct Step {
    double step_s = 0.0;  // from the instant before
    MotionState predicted;
    Eigen::Matrix3d gain = Eigen::Matrix3d::Zero();  // A (I + P A)^-1 of A measured, P predicted
    Eigen::Vector3d pull = Eigen::Vector3d::Zero();  // (I + A P)^-1 (b - A x)
  };
  template <class Visit>
  void go_back(std::size_t instants, bool with_covariances, const Visit& visit) const;

  double density_;
  MotionState now_;
  std::vector<Step> steps_;
};

}  // namespace trilat
