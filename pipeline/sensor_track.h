// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "datasets/session/session_clock.h"
#include "datasets/session/session_reader.h"

namespace trilat {

// What one sensor says of one joint at one instant.
struct SensorJoint {
  bool seen = false;
  Eigen::Vector3d point_in_sensor_m = Eigen::Vector3d::Zero();
  TrackingState state = TrackingState::not_tracked;
};

// One sensor's body joints as a function of host time, read from the session block by block. A joint is
// interpolated linearly between two frames that both see it and are no farther apart than `longest_gap`; its
// state is the worse of the two. Of several bodies in a frame the one with the most tracked joints is taken
// (the first of equals).
class SensorTrack {
 public:
  SensorTrack(const SessionReader& session, std::size_t sensor,
              ClockMap<HostClock, SensorClock> host_from_sensor, std::vector<Joint> joints,
              Duration longest_gap);

  // One entry a joint; `t` must not go back from call to call.
  void observe(HostTime t, std::span<SensorJoint> joints);
  std::uint64_t frames_with_several_bodies() const { return several_bodies_; }

 private:
  struct Frame {
    HostTime time;
    std::vector<SensorJoint> joints;
  };
  bool load_next();
  Frame frame_from(const BodyFrame& frame);

  const SessionReader* session_;
  std::size_t sensor_;
  ClockMap<HostClock, SensorClock> host_from_sensor_;
  std::vector<Joint> joints_;
  Duration longest_gap_;
  std::uint64_t next_row_ = 0;
  std::vector<BodyFrame> block_;
  std::size_t block_position_ = 0;
  Frame before_, after_;  // before_.time <= t < after_.time once both are loaded
  bool has_before_ = false, has_after_ = false, ended_ = false;
  std::uint64_t several_bodies_ = 0;
};

}  // namespace trilat
