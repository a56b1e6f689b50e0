// SPDX-License-Identifier: MIT
#include "pipeline/sensor_track.h"

#include <algorithm>
#include <cmath>

namespace trilat {
namespace {

constexpr std::uint64_t kBlock = 512;

const Body* chosen_body(const BodyFrame& frame) {
  const Body* best = nullptr;
  std::ptrdiff_t most = -1;
  for (const Body& body : frame.bodies) {
    const auto tracked = std::count(body.tracking_state.begin(), body.tracking_state.end(),
                                    static_cast<std::uint8_t>(TrackingState::tracked));
    if (tracked > most) {
      most = tracked;
      best = &body;
    }
  }
  return best;
}

SensorJoint joint_from(const Body& body, Joint joint) {
  const auto j = static_cast<std::size_t>(joint);
  const auto& p = body.position_m[j];
  SensorJoint result;
  result.point_in_sensor_m = Eigen::Vector3f(p[0], p[1], p[2]).cast<double>();
  const std::uint8_t state = body.tracking_state[j];
  result.seen = (state == 1 || state == 2) && result.point_in_sensor_m.allFinite();
  result.state = result.seen ? static_cast<TrackingState>(state) : TrackingState::not_tracked;
  return result;
}

}  // namespace

SensorTrack::SensorTrack(const SessionReader& session, std::size_t sensor,
                         ClockMap<HostClock, SensorClock> host_from_sensor, std::vector<Joint> joints,
                         Duration longest_gap)
    : session_(&session),
      sensor_(sensor),
      host_from_sensor_(host_from_sensor),
      joints_(std::move(joints)),
      longest_gap_(longest_gap) {}

SensorTrack::Frame SensorTrack::frame_from(const BodyFrame& frame) {
  const SensorDescription& description = session_->header().sensors[sensor_];
  Frame result{host_from_sensor_(device_time(description, frame.stamp)), {}};
  result.joints.resize(joints_.size());
  if (frame.bodies.size() > 1) ++several_bodies_;
  if (const Body* body = chosen_body(frame))
    for (std::size_t j = 0; j < joints_.size(); ++j) result.joints[j] = joint_from(*body, joints_[j]);
  return result;
}

// Moves on by one frame; frames whose time does not rise are left out.
bool SensorTrack::load_next() {
  while (!ended_) {
    if (block_position_ == block_.size()) {
      const std::uint64_t rows = session_->counts(sensor_).body_frames;
      block_ = session_->body_frames(sensor_, next_row_, std::min(kBlock, rows - next_row_));
      next_row_ += block_.size();
      block_position_ = 0;
      if (block_.empty()) {
        ended_ = true;
        return false;
      }
    }
    Frame frame = frame_from(block_[block_position_++]);
    if (has_after_ && frame.time <= after_.time) continue;
    before_ = std::move(after_);
    has_before_ = has_after_;
    after_ = std::move(frame);
    has_after_ = true;
    return true;
  }
  return false;
}

void SensorTrack::observe(HostTime t, std::span<SensorJoint> joints) {
  while ((!has_after_ || after_.time <= t) && load_next()) {
  }
  std::fill(joints.begin(), joints.end(), SensorJoint{});
  if (has_after_ && after_.time == t) {  // only at the very last frame
    std::copy(after_.joints.begin(), after_.joints.end(), joints.begin());
    return;
  }
  if (has_before_ && before_.time == t) {
    std::copy(before_.joints.begin(), before_.joints.end(), joints.begin());
    return;
  }
  if (!has_before_ || !has_after_ || t < before_.time || after_.time < t ||
      after_.time - before_.time > longest_gap_)
    return;
  const double share =
      static_cast<double>((t - before_.time).ns) / static_cast<double>((after_.time - before_.time).ns);
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const SensorJoint& a = before_.joints[j];
    const SensorJoint& b = after_.joints[j];
    if (a.seen && b.seen)
      joints[j] = {true, a.point_in_sensor_m + share * (b.point_in_sensor_m - a.point_in_sensor_m),
                   std::min(a.state, b.state)};
  }
}

}  // namespace trilat
