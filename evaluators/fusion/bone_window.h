// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "evaluators/fusion/joint_observation.h"
#include "evaluators/solvers/point_estimate.h"

namespace trilat {

// All joints of a person over time as one least-squares problem for each window of time: every joint moves as
// in KalmanOptions, and the bones between them keep their lengths.
struct BoneWindowOptions {
  double window_s = 2.0;         // each overlaps the next by half; its middle half is what it answers
  double sigma_m = 0.03;         // of one tracked position, per axis
  double inferred_factor = 3.0;  // on it when the joint is inferred
  // Of the acceleration (KalmanOptions).
  double acceleration_density_m2_s3 = 5.0;
  double speed_sigma_m_s = 2.0;  // of a joint at the start of its path or of the window, per axis
  // Cauchy's loss: a tracked position farther off than about this counts less and less, an inferred one
  // inferred_factor times as far. Infinite: squares.
  double loss_scale_m = 0.1;
  // How far a bone's length may be from its median at each instant. Trackers do not follow the centres that
  // bones turn about: the bones they give vary by 3 to 25 mm within a recording (body_tracker.json).
  double bone_sigma_m = 0.01;
  double longest_gap_s = 0.215;  // how long a joint's path goes on without a position
  // |F_k - F_{k-1}| < tolerance * F: leaves some micrometres.
  double function_tolerance = 1e-8;
  int max_iterations = 200;  // of each window
};

// Observations of one person over time.
struct BodyPath {
  std::span<const std::int64_t> time_ns;  // must rise
  std::span<const Joint> joints;          // each once
  std::size_t sensors = 0;
  // Says what every sensor sees of a joint, by its number in the list, at an instant; is called from any
  // thread, for each some times. Positions that are not finite count as not seen.
  std::function<void(std::size_t instant, std::size_t joint, std::span<JointObservation> observations)>
      observe;
};

// A bone between two joints of the path, as numbers in its list.
struct MedianBone {
  std::size_t parent = 0, child = 0;
  double length_m = std::numeric_limits<double>::quiet_NaN();
};

// Instants [first, last) of a window, and those that it answers.
struct TimeWindow {
  std::size_t first = 0, last = 0;
  std::size_t answer_first = 0, answer_last = 0;
};

// What all windows share: where they start from, the bones, and which instants each takes.
struct BoneWindows {
  // By instant and joint: the smoother's path (solve_kalman without gate), NaN where there is none. Starts
  // the windows and says where a joint is answered.
  std::vector<Eigen::Vector3d> start_m;
  // Of every joint whose parent is in the path: the median over the take of the smoother's distance between
  // both, at instants when some sensor tracks each. A bone that has no such instant is free. The length is of
  // the take and not an unknown of each window: a person has one skeleton, and a window in which a bone
  // hardly turns cannot tell its length from the joints' errors.
  std::vector<MedianBone> bones;
  std::vector<TimeWindow> windows;  // every instant is answered by one
};

// InternalError when times do not rise or a joint stands twice.
[[nodiscard]] BoneWindows plan_bone_windows(const BodyPath& path, const BoneWindowOptions& options);

// Minimises one window's cost (Levenberg-Marquardt, its steps by conjugate gradients) and gives the estimates
// of the instants it answers, by instant and joint: converged, iteration_limit, diverged, or no_observation
// where the smoother has no path. Windows do not depend on each other and may be solved at the same time.
// Covariances stay NaN.
[[nodiscard]] std::vector<PointEstimate> solve_bone_window(const BodyPath& path, const BoneWindows& windows,
                                                           std::size_t window,
                                                           const BoneWindowOptions& options);

}  // namespace trilat
