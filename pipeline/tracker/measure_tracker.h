// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "datasets/geometry/depth_camera.h"
#include "datasets/geometry/rigid_transform.h"
#include "datasets/synthetic/tracker/body_tracker_spec.h"
#include "evaluators/bodies/observed_body.h"

namespace trilat {

// What a truth says: that of a simulation is of the joints' centres and of the same clock; markers stand off
// a joint's centre, and a clock that was set by the motion hides a lag.
enum class TruthKind { none, markers, exact };

// One person in one take, as all sensors of a rig see them, at instants `step_s` apart.
struct WatchedTake {
  std::string participant;
  std::string rig;  // in takes of the same rig a sensor is the same
  double step_s = 0.1;
  std::vector<RigidTransform> world_from_sensor;
  std::vector<DepthIntrinsics> intrinsics;
  BodyTracks bodies{0, 0};
  TruthKind truth_kind = TruthKind::none;
  std::vector<Eigen::Vector3d> truth_m;  // by instant and joint, in the world; NaN where there is none
  // Robust size of what a resting joint shakes by from frame to frame; NaN where no joint of a group rests.
  std::array<double, kTrackerGroups> jitter_m{};
};

// `low` and `high`: 95 % interval over participants (jackknife, Student's t); NaN for fewer than three.
struct MeasuredParameter {
  std::string name, group;  // no group: of all joints
  double value = 0.0, low = std::numeric_limits<double>::quiet_NaN(), high = low;
  std::size_t participants = 0;
};

struct UntoldParameter {
  std::string name, why;
};

struct TrackerMeasurement {
  std::vector<MeasuredParameter> measured;
  std::vector<UntoldParameter> untold;
};

// The parameters of the simulated tracker (datasets/synthetic/tracker) that explain the takes, by the method
// of moments. Products of errors at two instants have the expectation
//   sum over +-, +-  (common + view cos(a - a') + own [same sensor]) of the bias, and of the wander times
//   exp(-path / wander_path_m), with azimuths a of the sensors,
// of an error against the truth as of the difference of two sensors: linear in six variances, which least
// squares find for each group of joints. Joints that the body hides are left out and give the error of hidden
// joints; instants at which sensors see different sides are left out and give that of exchanges.
TrackerMeasurement measure_tracker(std::span<const WatchedTake> takes);

// The robust size of second differences of frames in which a joint rests, over sqrt(6), by group; `bodies`
// are consecutive frames of one sensor, `time_s` when they were taken.
std::array<double, kTrackerGroups> resting_jitter_m(std::span<const double> time_s,
                                                    std::span<const ObservedBody> bodies);

}  // namespace trilat
