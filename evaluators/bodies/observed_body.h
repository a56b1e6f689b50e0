// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "datasets/rig/skeleton.h"

namespace trilat {

// One body as one sensor's tracker gives it at one instant, in that sensor's frame, metres. A joint is there
// when its state is not not_tracked; its position is finite then. Single precision, as the tracker delivers.
struct ObservedBody {
  std::array<Eigen::Vector3f, kJointCount> joint_in_sensor_m;
  std::array<TrackingState, kJointCount> state{};

  ObservedBody() { joint_in_sensor_m.fill(Eigen::Vector3f::Zero()); }
  bool has(std::size_t joint) const { return state[joint] != TrackingState::not_tracked; }
  bool has(Joint joint) const { return has(static_cast<std::size_t>(joint)); }
  Eigen::Vector3d at(Joint joint) const {
    return joint_in_sensor_m[static_cast<std::size_t>(joint)].cast<double>();
  }
};

// Views of one person by the sensors of a rig during a take: at every instant one body a sensor, without any
// joint where the sensor does not see the person.
class BodyTracks {
 public:
  BodyTracks(std::size_t instants, std::size_t sensors) : sensors_(sensors), bodies_(instants * sensors) {}
  std::size_t instants() const { return sensors_ == 0 ? 0 : bodies_.size() / sensors_; }
  std::size_t sensors() const { return sensors_; }
  ObservedBody& at(std::size_t instant, std::size_t sensor) { return bodies_[instant * sensors_ + sensor]; }
  const ObservedBody& at(std::size_t instant, std::size_t sensor) const {
    return bodies_[instant * sensors_ + sensor];
  }

 private:
  std::size_t sensors_;
  std::vector<ObservedBody> bodies_;
};

}  // namespace trilat
