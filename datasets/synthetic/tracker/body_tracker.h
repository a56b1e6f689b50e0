// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "datasets/synthetic/depth/joint_visibility.h"
#include "datasets/synthetic/simulated_sensor.h"
#include "datasets/synthetic/tracker/body_tracker_spec.h"
#include "datasets/synthetic/tracker/joint_errors.h"
#include "datasets/synthetic/tracker/tracker_truth.h"

namespace trilat {

// What a tracker says of one frame, and the truth about the participant.
struct TrackedFrame {
  std::vector<Body> bodies;  // in the order of the tracker's slots
  TrackerTruth truth;
};

// One sensor's body tracker in one take. A body is there while one of its joints is in view and not hidden;
// joints outside the image or the range are not tracked, hidden ones inferred (or wrongly tracked). What it
// says depends on nothing but the spec, the keys and the poses: not on other sensors.
class BodyTracker {
 public:
  BodyTracker(const BodyTrackerSpec& spec, const SensorSpec& sensor_spec, const SimulatedSensor& sensor,
              const SimulatedItem& item, std::size_t persons);

  // Frames 0, 1, 2, … each once, also those that will be dropped; the participant's pose is the first.
  TrackedFrame observe(std::uint64_t frame, std::span<const SkeletonPose> poses);

 private:
  struct TrackedPerson {
    TrackerKey key;
    JointErrors errors;
    std::uint64_t tracking_id = 0;  // 0: not tracked
    std::size_t slot = 0;
    bool back_seen = false, exchanged = false;
  };
  struct Sight {  // which joints of a person are in view, and hidden there
    std::bitset<kJointCount> in_view, hidden;
  };
  Sight sight_of(std::size_t person, const SkeletonPose& pose);
  // Whether the back is seen, and taken for the front.
  void note_back(TrackedPerson& person, const BodyView& view, std::uint64_t frame) const;
  void note_identity(TrackedPerson& person, bool seen, std::uint64_t frame);
  Body body_of(const TrackedPerson& person, const Sight& sight,
               const std::array<Eigen::Vector3d, kJointCount>& joint_in_world_m) const;

  BodyTrackerSpec spec_;
  SensorSpec sensor_spec_;
  SimulatedSensor sensor_;
  SimulatedItem item_;
  JointVisibility visibility_;
  std::vector<TrackedPerson> persons_;
  std::uint64_t next_frame_ = 0;
  std::uint64_t identities_ = 0;  // given so far
};

}  // namespace trilat
