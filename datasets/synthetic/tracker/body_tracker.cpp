// SPDX-License-Identifier: MIT
#include "datasets/synthetic/tracker/body_tracker.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "datasets/base/error.h"

namespace trilat {
namespace {

constexpr std::size_t kSlots = kMaxBodies;

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
                         const SimulatedSensor& sensor, const SimulatedItem& item, std::size_t persons)
    : spec_(spec), sensor_spec_(sensor_spec), sensor_(sensor), item_(item), visibility_(sensor.intrinsics) {
  TRILAT_CHECK(persons >= 1 && persons <= kSlots && sensor.index < 64, "the tracker has room for everybody");
  for (std::size_t p = 0; p < persons; ++p) {
    const TrackerKey key{item.seed, item.take, item.participant, sensor.index, p};
    persons_.push_back({key, JointErrors(spec, sensor_spec.rate_hz, key, sensor.unit)});
  }
}

BodyTracker::Sight BodyTracker::sight_of(std::size_t person, const SkeletonPose& pose) {
  const RigidTransform sensor_from_world = sensor_.pose.world_from_sensor.inverse();
  Sight sight;
  for (std::size_t j = 0; j < kJointCount; ++j)
    sight.in_view[j] =
        pose.present[j] && is_in_view(sensor_, sensor_spec_, sensor_from_world * pose.joint_in_world_m[j]);
  if (spec_.least_visible_share > 0.0)
    sight.hidden = visibility_.hidden_joints(person, spec_.least_visible_share) & sight.in_view;
  return sight;
}

void BodyTracker::note_back(TrackedPerson& person, const BodyView& view, std::uint64_t frame) const {
  const double angle_rad = std::abs(view.azimuth_rad);
  const bool was_exchanged = person.exchanged;
  if (angle_rad <= spec_.back_view_angle_rad)
    person.exchanged = false;
  else if (!person.back_seen)
    person.exchanged =
        person.key.stream(Purpose::tracker_exchange, 0, frame).uniform(0) < spec_.exchanged_share;
  person.back_seen = angle_rad > spec_.back_view_angle_rad;
  if (person.exchanged != was_exchanged) person.errors.restart();
}

// A new identity takes any free slot, as in the SDK: the order of bodies says nothing.
void BodyTracker::note_identity(TrackedPerson& person, bool seen, std::uint64_t frame) {
  if (!seen) {
    person.tracking_id = 0;
    return;
  }
  const RandomStream random = person.key.stream(Purpose::tracker_identity, 0, frame);
  if (person.tracking_id != 0 &&
      random.uniform(0) >= spec_.identity_changes_per_minute / 60.0 / sensor_spec_.rate_hz)
    return;
  person.tracking_id = 0;
  std::vector<std::size_t> free_slots;
  for (std::size_t slot = 0; slot < kSlots; ++slot)
    if (std::ranges::none_of(persons_, [&](const TrackedPerson& other) {
          return other.tracking_id != 0 && other.slot == slot;
        }))
      free_slots.push_back(slot);
  person.slot =
      free_slots[static_cast<std::size_t>(random.uniform(1) * static_cast<double>(free_slots.size()))];
  // as the SDK does, above 2^56; no two of a campaign are equal
  person.tracking_id =
      (std::uint64_t{1} << 56) + ((item_.take + 1) << 40) + ((sensor_.index + 1) << 32) + ++identities_;
}

Body BodyTracker::body_of(const TrackedPerson& person, const Sight& sight,
                          const std::array<Eigen::Vector3d, kJointCount>& joint_in_world_m) const {
  const RigidTransform sensor_from_world = sensor_.pose.world_from_sensor.inverse();
  Body body;
  body.tracking_id = person.tracking_id;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    if (!sight.in_view[j]) continue;
    const bool inferred = sight.hidden[j] && !person.errors.said_to_be_tracked(j);
    body.tracking_state[j] =
        static_cast<std::uint8_t>(inferred ? TrackingState::inferred : TrackingState::tracked);
    const Eigen::Vector3f point_m = (sensor_from_world * joint_in_world_m[j]).cast<float>();
    body.position_m[j] = {point_m.x(), point_m.y(), point_m.z()};
  }
  return body;
}

TrackedFrame BodyTracker::observe(std::uint64_t frame, std::span<const SkeletonPose> poses) {
  TRILAT_CHECK(frame == next_frame_++ && poses.size() == persons_.size(),
               "a tracker sees every frame once, in order, with everybody");
  if (spec_.least_visible_share > 0.0) visibility_.set_persons(poses, sensor_.pose.world_from_sensor);
  TrackedFrame result;
  result.truth.sequence = static_cast<std::int64_t>(frame);
  std::vector<std::pair<std::size_t, Body>> by_slot;
  for (std::size_t p = 0; p < persons_.size(); ++p) {
    TrackedPerson& person = persons_[p];
    const Sight sight = sight_of(p, poses[p]);
    const Eigen::Vector3d& sensor_m = sensor_.pose.world_from_sensor.translation_m;
    note_back(person, body_view(poses[p], sensor_m), frame);
    note_identity(person, (sight.in_view & ~sight.hidden).any(), frame);
    const SkeletonPose taken = person.exchanged ? turned_round(poses[p]) : poses[p];
    const Sight shown = person.exchanged
                            ? Sight{with_sides_exchanged(sight.in_view), with_sides_exchanged(sight.hidden)}
                            : sight;
    const auto joint_in_world_m = person.errors.step(frame, taken, body_view(taken, sensor_m), shown.hidden);
    if (person.tracking_id != 0) by_slot.emplace_back(person.slot, body_of(person, shown, joint_in_world_m));
    if (p > 0) continue;
    result.truth.hidden = static_cast<std::uint32_t>(sight.hidden.to_ulong());
    result.truth.exchanged = person.exchanged;
    result.truth.tracking_id = person.tracking_id;
  }
  std::ranges::sort(by_slot, [](const auto& a, const auto& b) { return a.first < b.first; });
  for (auto& [slot, body] : by_slot) result.bodies.push_back(body);
  return result;
}

}  // namespace trilat
