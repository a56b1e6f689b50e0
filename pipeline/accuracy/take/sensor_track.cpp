// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/sensor_track.h"

#include <algorithm>

namespace trilat {
namespace {

constexpr std::uint64_t kTrackBlock = 512;

ObservedBody observed(const Body& body) {
  ObservedBody result;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const auto& p = body.position_m[j];
    const Eigen::Vector3f point(p[0], p[1], p[2]);
    const std::uint8_t state = body.tracking_state[j];
    if ((state != 1 && state != 2) || !point.allFinite()) continue;
    result.joint_in_sensor_m[j] = point;
    result.state[j] = static_cast<TrackingState>(state);
  }
  return result;
}

// Whether left and right are exchanged from one frame to the next: mirrored, the later body is far nearer to
// the earlier one.
bool changes_sides(const ObservedBody& a, const ObservedBody& b) {
  double straight_m = 0.0, mirrored_m = 0.0;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const auto mirror = static_cast<std::size_t>(mirror_of(static_cast<Joint>(j)));
    if (mirror == j || !a.has(j) || !b.has(j) || !b.has(mirror)) continue;
    straight_m += static_cast<double>((a.joint_in_sensor_m[j] - b.joint_in_sensor_m[j]).norm());
    mirrored_m += static_cast<double>((a.joint_in_sensor_m[j] - b.joint_in_sensor_m[mirror]).norm());
  }
  return mirrored_m < 0.5 * straight_m;
}

// Linear, but never across a change of sides, of which no exchange could be undone any more: there it is the
// nearer frame.
ObservedBody between(const ObservedBody& a, const ObservedBody& b, double share) {
  if (changes_sides(a, b)) return share < 0.5 ? a : b;
  ObservedBody result;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    if (!a.has(j) || !b.has(j)) continue;
    const Eigen::Vector3d from = a.joint_in_sensor_m[j].cast<double>();
    result.joint_in_sensor_m[j] =
        (from + share * (b.joint_in_sensor_m[j].cast<double>() - from)).cast<float>();
    result.state[j] = std::min(a.state[j], b.state[j]);
  }
  return result;
}

}  // namespace

SensorTrack::SensorTrack(const SessionReader& session, std::size_t sensor, SensorClockMap host_from_sensor,
                         Duration longest_gap)
    : session_(&session),
      sensor_(sensor),
      host_from_sensor_(std::move(host_from_sensor)),
      longest_gap_(longest_gap) {}

const Body* SensorTrack::chosen_body(const BodyFrame& frame) const {
  const Body* best = nullptr;
  std::ptrdiff_t most = -1;
  for (const Body& body : frame.bodies) {
    if (wanted_ids_ && !wanted_ids_->contains(body.tracking_id)) continue;
    const auto tracked = std::count(body.tracking_state.begin(), body.tracking_state.end(),
                                    static_cast<std::uint8_t>(TrackingState::tracked));
    if (tracked > most) {
      most = tracked;
      best = &body;
    }
  }
  return best;
}

SensorTrack::Frame SensorTrack::frame_from(const BodyFrame& frame) {
  Frame result{host_from_sensor_(frame.stamp), {}};
  if (const Body* body = chosen_body(frame)) result.body = observed(*body);
  return result;
}

// Moves on by one frame; frames whose time does not rise are left out.
bool SensorTrack::load_next() {
  while (!ended_) {
    if (block_position_ == block_.size()) {
      const std::uint64_t rows = session_->counts(sensor_).body_frames;
      block_ = session_->body_frames(sensor_, next_row_, std::min(kTrackBlock, rows - next_row_));
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

void SensorTrack::observe(HostTime t, ObservedBody& body) {
  while ((!has_after_ || after_.time <= t) && load_next()) {
  }
  body = {};
  if (has_after_ && after_.time == t) {  // only at the very last frame
    body = after_.body;
    return;
  }
  if (has_before_ && before_.time == t) {
    body = before_.body;
    return;
  }
  if (!has_before_ || !has_after_ || t < before_.time || after_.time < t ||
      after_.time - before_.time > longest_gap_)
    return;
  const double share =
      static_cast<double>((t - before_.time).ns) / static_cast<double>((after_.time - before_.time).ns);
  body = between(before_.body, after_.body, share);
}

}  // namespace trilat
