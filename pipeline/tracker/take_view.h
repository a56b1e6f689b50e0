// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "pipeline/tracker/measure_tracker.h"
#include "pipeline/tracker/moments.h"

namespace trilat {

constexpr std::size_t kRays = 5;  // about a joint, of which a share is visible

inline std::size_t group_of(std::size_t joint) {
  return static_cast<std::size_t>(tracker_group_of(static_cast<Joint>(joint)));
}

// What one participant's takes say.
struct ParticipantSums {
  std::array<Sums, kTrackerGroups> products, increments;
  // Of hidden joints: the squares an axis, and what they would be if they were seen.
  std::array<double, kTrackerGroups> hidden_squares{}, hidden_count{};
  std::array<Row, kTrackerGroups> hidden_row;
  double inferred = 0.0, hidden_joints = 0.0;
  // By what share of a joint is visible, of five rays: how many are gross, of how many.
  std::array<std::array<double, 2>, kRays + 1> gross_by_share{};
  double along = 0.0, across = 0.0, rays = 0.0;
  double with_velocity = 0.0, velocities = 0.0, accelerations = 0.0;  // of errors against an exact truth
  // How far off the front a body is seen, and whether its back is taken for the front.
  std::vector<std::pair<double, bool>> backs;
  std::array<std::vector<double>, kTrackerGroups> jitter_m;

  ParticipantSums() { hidden_row.fill(Row::Zero()); }
};

// An error against the truth, or the difference of two sensors, of all joints at one instant, in the body's
// frame.
struct Observation {
  std::size_t take = 0, instant = 0;
  std::array<std::size_t, 2> sensor{};  // the second only of a difference
  std::array<double, 2> azimuth_rad{};
  bool difference = false;
  Eigen::Matrix3d body_from_world;
  std::array<Eigen::Vector3d, kJointCount> error_m;
  std::array<double, kJointCount> path_m{};  // gone since the take's start
};

// Every `stride`-th instant of a take as errors; what is counted at all instants goes into `sums`. `number`
// tells takes apart.
std::vector<Observation> observe_take(const WatchedTake& take, std::size_t number, std::size_t stride,
                                      ParticipantSums& sums);

// Takes the lag out of errors against an exact truth: a first-order filter errs by -lag times the speed and
// lag^2 times the acceleration.
void undo_lag(const WatchedTake& take, std::vector<Observation>& observations, ParticipantSums& sums);

// Products of errors at two instants: they tell the bias.
void add_products(const std::vector<Observation>& all, ParticipantSums& sums);

// Half the products of two changes over one time: they tell the wander, for what stays falls out, a marker's
// distance from its joint as well.
void add_increments(const std::vector<Observation>& all, const WatchedTake& take, ParticipantSums& sums);

}  // namespace trilat
