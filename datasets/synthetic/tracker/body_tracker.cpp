// SPDX-License-Identifier: MIT
#include "datasets/synthetic/tracker/body_tracker.h"

#include <cmath>
#include <numbers>

#include "datasets/base/error.h"

namespace trilat {
namespace {

std::bitset<kJointCount> with_sides_exchanged(const std::bitset<kJointCount>& joints) {
  std::bitset<kJointCount> exchanged;
  for (std::size_t j = 0; j < kJointCount; ++j)
    exchanged[j] = joints[static_cast<std::size_t>(mirror_of(static_cast<Joint>(j)))];
  return exchanged;
}

// The back taken for the front: the body faces the other way, and left is right.
SkeletonPose turned_round(const SkeletonPose& pose) {
  SkeletonPose turned;
  for (std::size_t j = 0; j < kJointCount; ++j)
    turned.joint_in_world_m[j] = pose.at(mirror_of(static_cast<Joint>(j)));
  turned.present = with_sides_exchanged(pose.present);
  if (pose.heading_rad != 0.0) turned.heading_rad = pose.heading_rad + std::numbers::pi;
  return turned;
}

}  // namespace

BodyTracker::BodyTracker(const BodyTrackerSpec& spec, const SensorSpec& sensor_spec,
                         const SimulatedSensor& sensor, const SimulatedItem& item)
    : spec_(spec),
      sensor_spec_(sensor_spec),
      sensor_(sensor),
      item_(item),
      visibility_(sensor.intrinsics),
      key_{item.seed, item.take, item.participant, sensor.index},
      errors_(spec, sensor_spec.rate_hz, key_, sensor.unit) {
  TRILAT_CHECK(sensor.index < 64, "random numbers tell 64 sensors apart");
}

BodyTracker::Visibility BodyTracker::sight_of(const SkeletonPose& pose) {
  const RigidTransform sensor_from_world = sensor_.pose.world_from_sensor.inverse();
  Visibility sight;
  for (std::size_t j = 0; j < kJointCount; ++j)
    sight.in_view[j] =
        pose.present[j] && is_in_view(sensor_, sensor_spec_, sensor_from_world * pose.joint_in_world_m[j]);
  if (spec_.least_visible_share > 0.0) {
    visibility_.set_person(pose, sensor_.pose.world_from_sensor);
    sight.hidden = visibility_.hidden_joints(spec_.least_visible_share) & sight.in_view;
  }
  return sight;
}

void BodyTracker::update_back_view(const BodyView& view, std::uint64_t frame) {
  const bool back = std::abs(view.azimuth_rad) > spec_.back_view_angle_rad;
  const bool was_exchanged = exchanged_;
  if (!back)
    exchanged_ = false;
  else if (!back_seen_)
    exchanged_ = key_.stream(Purpose::tracker_exchange, 0, frame).uniform(0) < spec_.exchanged_share;
  back_seen_ = back;
  if (exchanged_ != was_exchanged) errors_.restart();
}

Body BodyTracker::body_of(const Visibility& sight,
                          const std::array<Eigen::Vector3d, kJointCount>& joint_in_world_m) const {
  const RigidTransform sensor_from_world = sensor_.pose.world_from_sensor.inverse();
  Body body;
  body.tracking_id = tracking_id_;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    if (!sight.in_view[j]) continue;
    const bool inferred = sight.hidden[j] && !errors_.reported_as_tracked(j);
    body.tracking_state[j] =
        static_cast<std::uint8_t>(inferred ? TrackingState::inferred : TrackingState::tracked);
    const Eigen::Vector3f point_m = (sensor_from_world * joint_in_world_m[j]).cast<float>();
    body.position_m[j] = {point_m.x(), point_m.y(), point_m.z()};
  }
  return body;
}

TrackedFrame BodyTracker::observe(std::uint64_t frame, const SkeletonPose& pose) {
  TRILAT_CHECK(frame == next_frame_++, "a tracker sees every frame once, in order");
  const Visibility sight = sight_of(pose);
  const Eigen::Vector3d& sensor_m = sensor_.pose.world_from_sensor.translation_m;
  update_back_view(body_view(pose, sensor_m), frame);
  // The SDK gives numbers above 2^56, and a new one to a person who comes back. No two in a campaign are
  // equal.
  if ((sight.in_view & ~sight.hidden).none())
    tracking_id_ = 0;
  else if (tracking_id_ == 0)
    tracking_id_ =
        (std::uint64_t{1} << 56) + ((item_.take + 1) << 40) + ((sensor_.index + 1) << 32) + ++identities_;
  const SkeletonPose taken = exchanged_ ? turned_round(pose) : pose;
  const Visibility shown =
      exchanged_ ? Visibility{with_sides_exchanged(sight.in_view), with_sides_exchanged(sight.hidden)}
                 : sight;
  const auto joint_in_world_m = errors_.step(frame, taken, body_view(taken, sensor_m), shown.hidden);
  TrackedFrame result{std::nullopt, sight.hidden, exchanged_};
  if (tracking_id_ != 0) result.body = body_of(shown, joint_in_world_m);
  return result;
}

}  // namespace trilat
