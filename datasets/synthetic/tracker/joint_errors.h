// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <bitset>
#include <cstdint>

#include "datasets/base/philox.h"
#include "datasets/synthetic/depth/depth_renderer.h"
#include "datasets/synthetic/motion.h"
#include "datasets/synthetic/tracker/body_tracker_spec.h"

namespace trilat {

// Key of a tracker's random numbers: which sensor tracks whom in which take.
struct TrackerKey {
  std::uint64_t seed = 1;
  std::uint64_t take = 0;
  std::uint64_t participant = 0;
  std::uint64_t sensor = 0;  // below 64

  RandomStream stream(Purpose purpose, std::uint64_t part, std::uint64_t frame) const;
  // Random numbers of the errors that all sensors share.
  TrackerKey shared_stream() const;
  // Random numbers that are the same for all sensors, and for a participant in all takes.
  RandomStream body_stream(Purpose purpose, std::uint64_t joint) const;
  // Random numbers of this sensor, for a participant in all takes.
  RandomStream sensor_stream(Purpose purpose, std::uint64_t joint) const;
};

// How a person stands to a sensor: the way that the body faces (as SkeletonPose) and the direction in which
// it sees the sensor, from its forward towards its left, horizontally.
struct BodyView {
  double heading_rad = 0.0;
  double azimuth_rad = 0.0;  // within +-pi
  Eigen::Vector3d sensor_in_world_m = Eigen::Vector3d::Zero();
};
// A pose without heading (0) has that of its shoulders, else of its hips, else 0.
BodyView body_view(const SkeletonPose& pose, const Eigen::Vector3d& sensor_in_world_m);

// A random vector of the body's own frame (x left, y up, z forward) in its parts: the same for all sensors,
// by the direction of view, of one sensor.
struct ViewDependentError {
  Eigen::Vector3d common{0.0, 0.0, 0.0}, facing{0.0, 0.0, 0.0}, beside{0.0, 0.0, 0.0}, own{0.0, 0.0, 0.0};

  Eigen::Vector3d seen_from(double azimuth_rad) const;
};

// Joints of a person as one sensor's tracker puts them, frame by frame: the truth with lag, systematic error,
// drift, jitter, jumps, and what is added while a joint is hidden.
class JointErrors {
 public:
  JointErrors(const BodyTrackerSpec& spec, double rate_hz, const TrackerKey& key, const DepthUnit& unit);

  // Frames in rising order, each once; in the world's frame. Joints that are not present are left at zero.
  std::array<Eigen::Vector3d, kJointCount> step(std::uint64_t frame, const SkeletonPose& pose,
                                                const BodyView& view, const std::bitset<kJointCount>& hidden);
  // The next frame follows none: nothing lags.
  void restart();
  // Hidden in the last frame, but said to be tracked.
  bool reported_as_tracked(std::size_t joint) const { return joints_[joint].reported_as_tracked; }

 private:
  struct JointState {
    ViewDependentError bias_m, drift_m, hidden_m;
    Eigen::Vector3d lagged_m, truth_m;
    Eigen::Vector3d jump_m;
    std::uint64_t jump_end = 0;  // the first frame without
    bool has_drift = false, has_truth = false, hidden = false, reported_as_tracked = false;
  };
  Eigen::Vector3d follow(JointState& state, const Eigen::Vector3d& truth_m) const;
  void drift(JointState& state, std::size_t joint, std::uint64_t frame, double step_m) const;
  Eigen::Vector3d along_and_across(const Eigen::Vector3d& error_m, const Eigen::Vector3d& ray) const;
  Eigen::Vector3d jump(JointState& state, std::size_t joint, std::uint64_t frame) const;
  void note_hidden(JointState& state, std::size_t joint, std::uint64_t frame, bool hidden) const;

  BodyTrackerSpec spec_;
  double rate_hz_;
  TrackerKey key_;
  DepthUnit unit_;
  std::array<JointState, kJointCount> joints_;
};

}  // namespace trilat
