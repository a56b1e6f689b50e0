// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

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

}  // namespace trilat
