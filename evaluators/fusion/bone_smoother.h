// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "datasets/base/units.h"
#include "evaluators/fusion/joint_observation.h"
#include "evaluators/solvers/point_estimate.h"

namespace trilat {

// All joints of a person over time as one least-squares problem: every joint moves as in KalmanOptions, and
// the bones between them keep their lengths.
struct BoneSmootherOptions {
  double sigma_m = 0.03;         // of one tracked position, per axis
  double inferred_factor = 3.0;  // on it when the joint is inferred
  // Spectral density of the acceleration (KalmanOptions).
  double acceleration_density_m2_s3 = 5.0;
  double speed_sigma_m_s = 2.0;  // of a joint at the start of its path, per axis
  // Cauchy's loss: a tracked position farther off than about this counts less and less, an inferred one
  // inferred_factor times as far. Infinite: squares.
  double loss_scale_m = 0.1;
  // How far a bone's length may be from its median at each instant. Trackers do not follow the centres that
  // bones turn about: the bones they give vary by 3 to 25 mm within a recording (body_tracker.json).
  double bone_sigma_m = 0.01;
  double longest_gap_s = 0.215;    // how long a joint's path goes on without a position
  double step_tolerance_m = 1e-4;  // no joint moves farther in the last pass over all
  int max_iterations = 1000;       // such passes; an hour of simulated walking takes 134
};

// Observations of one person over time.
struct BodyPath {
  std::span<const std::int64_t> time_ns;  // must rise
  std::span<const Joint> joints;          // each once
  std::size_t sensors = 0;
  // Says what every sensor sees of a joint, by its number in the list, at an instant; is called for each many
  // times. Positions that are not finite count as not seen.
  std::function<void(std::size_t instant, std::size_t joint, std::span<JointObservation> observations)>
      observe;
};

// A bone between two joints of the path, as numbers in its list.
struct MedianBone {
  std::size_t parent = 0, child = 0;
  double length_m = kNaN;
};

struct SmoothedBody {
  // Positions and their statuses by instant and joint: NaN with no_observation where solve_kalman() without
  // gate has no path, else converged, or iteration_limit where the joint still moved.
  std::vector<Eigen::Vector3d> position_m;
  std::vector<SolveStatus> status;
  int passes = 0;
  // Length of the bone from each joint to its parent, where that is in the path: the median over the take of
  // the distance between both as solve_kalman() smooths them, at instants when some sensor tracks each. A
  // bone that has no such instant is free. The length is of the take and no unknown: a person has one
  // skeleton, and a time in which a bone hardly turns cannot tell its length from the joints' errors.
  std::vector<MedianBone> bones;
};

// One joint after the other is smoothed over its whole path (Rauch, Tung and Striebel 1965) while the others
// stay where they are, until none moves: a bone is a measurement along its direction, a sensor's position one
// with Cauchy's weight (Gauss-Newton by blocks, iteratively reweighted). InternalError when times do not rise
// or a joint stands twice.
[[nodiscard]] SmoothedBody smooth_bones(const BodyPath& path, const BoneSmootherOptions& options);

}  // namespace trilat
