// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>

#include "datasets/synthetic/depth/joint_visibility.h"
#include "datasets/synthetic/simulated_sensor.h"
#include "datasets/synthetic/tracker/body_tracker_spec.h"
#include "datasets/synthetic/tracker/joint_errors.h"

namespace trilat {

// Bodies of a tracker in one frame, and the truth that only the simulator knows.
struct TrackedFrame {
  std::optional<Body> body;         // nothing while the person is not tracked
  std::bitset<kJointCount> hidden;  // joints of the person, not of the body, that are in view but hidden
  bool exchanged = false;           // the body's left and right are the person's right and left
};

// One sensor's body tracker in one take. A body is there while one of its joints is in view and not hidden;
// joints outside the image or the range are not tracked, hidden ones inferred (or wrongly tracked). What it
// says depends on nothing but the spec, the keys and the poses: not on other sensors.
class BodyTracker {
 public:
  BodyTracker(const BodyTrackerSpec& spec, const SensorSpec& sensor_spec, const SimulatedSensor& sensor,
              const SimulatedItem& item);

  // Frames 0, 1, 2, … each once, also those that will be dropped.
  TrackedFrame observe(std::uint64_t frame, const SkeletonPose& pose);

 private:
  struct Visibility {  // which joints of the person are in view, and hidden there
    std::bitset<kJointCount> in_view, hidden;
  };
  Visibility sight_of(const SkeletonPose& pose);
  // Whether the back is seen, and taken for the front.
  void update_back_view(const BodyView& view, std::uint64_t frame);
  Body body_of(const Visibility& sight,
               const std::array<Eigen::Vector3d, kJointCount>& joint_in_world_m) const;

  BodyTrackerSpec spec_;
  SensorSpec sensor_spec_;
  SimulatedSensor sensor_;
  SimulatedItem item_;
  JointVisibility visibility_;
  TrackerKey key_;
  JointErrors errors_;
  std::uint64_t tracking_id_ = 0;  // 0: not tracked
  bool back_seen_ = false, exchanged_ = false;
  std::uint64_t next_frame_ = 0;
  std::uint64_t identities_ = 0;  // given so far
};

}  // namespace trilat
