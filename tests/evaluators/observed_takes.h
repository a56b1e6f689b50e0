// SPDX-License-Identifier: MIT
// Generated persons as a ring of body trackers would see them, with errors like theirs and with left and
// right exchanged where a sensor sees the back.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "datasets/base/philox.h"
#include "datasets/rig/rigid_transform.h"
#include "datasets/synthetic/generated_person.h"
#include "evaluators/bodies/observed_body.h"

namespace trilat::testing_support {

struct TakeSpec {
  Activity activity = Activity::walking;
  std::size_t sensors = 4;
  double exchange_probability = 0.5;  // of each stretch of half a second to ten in which the back is seen
  bool upper_body_only = false;
  bool toes_follow_labels = false;  // an exchanged body's toes point to where its labels say that it looks
  std::uint64_t take = 0;
  std::size_t instants = 900;  // at 30 Hz
};

struct ObservedTake {
  BodyTracks tracks;
  std::vector<RigidTransform> world_from_sensor;
  std::vector<std::uint8_t> exchanged;  // the truth, instants x sensors
  bool was_exchanged(std::size_t instant, std::size_t sensor) const {
    return exchanged[instant * tracks.sensors() + sensor] != 0;
  }
};

inline constexpr double kInstant_s = 1.0 / 30.0;
inline constexpr std::size_t kStretch = 15;  // instants for which a joint stays inferred or missing

// Random numbers of one take and sensor; `part` tells uses apart.
inline RandomStream stream_of(const TakeSpec& spec, std::size_t sensor, std::uint64_t part,
                              std::uint64_t step) {
  return {11, Purpose::test, random_item(spec.take, sensor, part, step)};
}

inline Eigen::Vector3d normal3(const RandomStream& random, std::uint32_t first) {
  return {random.normal(first), random.normal(first + 1), random.normal(first + 2)};
}

// Cosine between the person's forward and the direction to the sensor.
inline double facing(const SkeletonPose& pose, const RigidTransform& world_from_sensor) {
  const Eigen::Vector3d to_sensor = world_from_sensor.translation_m - pose.at(Joint::spine_mid);
  return (std::sin(pose.heading_rad) * to_sensor.x() + std::cos(pose.heading_rad) * to_sensor.z()) /
         std::hypot(to_sensor.x(), to_sensor.z());
}

// The constant part of a joint's error, 30 to 60 mm an axis; half of its variance turns with the view.
inline Eigen::Vector3d bias_m(const TakeSpec& spec, std::size_t sensor, std::size_t joint, double view_rad) {
  const RandomStream random = stream_of(spec, sensor, 1, joint);
  const double sigma_m = random.uniform(20, 0.03, 0.06);
  return sigma_m * std::sqrt(0.5) *
         (normal3(random, 0) + std::cos(view_rad) * normal3(random, 3) +
          std::sin(view_rad) * normal3(random, 6));
}

inline bool is_upper(Joint joint) {
  constexpr std::array kLower{Joint::spine_base,  Joint::hip_left,   Joint::hip_right,
                              Joint::knee_left,   Joint::knee_right, Joint::ankle_left,
                              Joint::ankle_right, Joint::foot_left,  Joint::foot_right};
  return std::ranges::find(kLower, joint) == kLower.end();
}

// Joints on the side that the body hides are inferred half of the time, others one stretch in fifteen.
inline TrackingState state_of(const TakeSpec& spec, const SkeletonPose& pose,
                              const RigidTransform& pose_of_sensor, std::size_t sensor, std::size_t joint,
                              std::size_t instant) {
  if (spec.upper_body_only && !is_upper(static_cast<Joint>(joint))) return TrackingState::not_tracked;
  if (stream_of(spec, sensor, 90, instant / kStretch).uniform(0) < 0.02) return TrackingState::not_tracked;
  const RandomStream random = stream_of(spec, sensor, 100 + joint, instant / kStretch);
  if (random.uniform(0) < 0.03) return TrackingState::not_tracked;
  const auto distance_m = [&](std::size_t j) {
    return (pose.joint_in_world_m[j] - pose_of_sensor.translation_m).norm();
  };
  const auto mirror = static_cast<std::size_t>(mirror_of(static_cast<Joint>(joint)));
  const bool far_side = distance_m(joint) > distance_m(mirror) + 0.15;
  return random.uniform(1) < (far_side ? 0.5 : 1.0 / 15.0) ? TrackingState::inferred : TrackingState::tracked;
}

// When a sensor exchanges: stretches of the back view, each exchanged with the stated probability.
inline std::vector<bool> draw_exchanges(const TakeSpec& spec, std::size_t sensor,
                                        const std::vector<bool>& sees_back) {
  std::vector<bool> exchanged(spec.instants, false);
  std::size_t begin = 0;
  for (std::uint64_t k = 0; begin < spec.instants; ++k) {
    const RandomStream random = stream_of(spec, sensor, 2, k);
    const auto length = static_cast<std::size_t>(random.uniform(0, 15.0, 300.0));
    const bool flip = random.uniform(1) < spec.exchange_probability;
    for (std::size_t i = begin; i < std::min(begin + length, spec.instants); ++i)
      exchanged[i] = flip && sees_back[i];
    begin += length;
  }
  for (std::size_t i = 0; i < spec.instants;) {  // shorter than half a second does not happen
    std::size_t end = i;
    while (end < spec.instants && exchanged[end]) ++end;
    if (end > i && end - i < 15)
      std::fill(exchanged.begin() + static_cast<std::ptrdiff_t>(i),
                exchanged.begin() + static_cast<std::ptrdiff_t>(end), false);
    i = end + 1;
  }
  return exchanged;
}

inline void exchange_sides(ObservedBody& body) {
  const ObservedBody before = body;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const auto mirror = static_cast<std::size_t>(mirror_of(static_cast<Joint>(j)));
    body.joint_in_sensor_m[j] = before.joint_in_sensor_m[mirror];
    body.state[j] = before.state[mirror];
  }
}

// Level in a sensor that looks down a little is near enough: y stays.
inline void turn_toes(ObservedBody& body) {
  for (const auto& [ankle, foot] : {std::pair{14, 15}, std::pair{18, 19}}) {
    const Eigen::Vector3f toes_m = body.joint_in_sensor_m[foot] - body.joint_in_sensor_m[ankle];
    body.joint_in_sensor_m[foot] += Eigen::Vector3f(-2.0f * toes_m.x(), 0.0f, -2.0f * toes_m.z());
  }
}

inline ObservedTake observed_take(const TakeSpec& spec) {
  constexpr double kDrift_m = 0.015, kJitter_m = 0.004, kInferredFactor = 3.0;
  const double keep = std::exp(-kInstant_s / 1.0);  // of the drift, whose correlation time is a second
  const Person person = draw_person(11, spec.take, 1.70, 0.17);
  const Motion motion = generated_motion(person, spec.activity);
  const double rig_turn = stream_of(spec, 9, 0, 0).uniform(0, 0.0, 2.0 * std::numbers::pi);
  ObservedTake take{
      BodyTracks(spec.instants, spec.sensors), {}, std::vector<std::uint8_t>(spec.instants * spec.sensors)};
  for (std::size_t s = 0; s < spec.sensors; ++s) {
    const double angle =
        rig_turn + 2.0 * std::numbers::pi * static_cast<double>(s) / static_cast<double>(spec.sensors);
    const double height_m = s % 2 == 0 ? 0.9 : 1.7;
    take.world_from_sensor.push_back(world_from_sensor_looking_at(
        {2.0 * std::sin(angle), height_m, 2.0 * std::cos(angle)}, {0.0, 1.0, 0.0}));
    const RigidTransform sensor_from_world = take.world_from_sensor[s].inverse();
    std::vector<bool> sees_back(spec.instants);
    std::array<Eigen::Vector3d, kJointCount> drift_m;
    for (std::size_t j = 0; j < kJointCount; ++j)
      drift_m[j] = kDrift_m * normal3(stream_of(spec, s, 3, j), 0);
    for (std::size_t i = 0; i < spec.instants; ++i) {
      const SkeletonPose pose = motion(static_cast<double>(i) * kInstant_s);
      sees_back[i] = facing(pose, take.world_from_sensor[s]) < -0.3;
      ObservedBody& body = take.tracks.at(i, s);
      for (std::size_t j = 0; j < kJointCount; ++j) {
        const RandomStream random = stream_of(spec, s, 10 + j, i);
        drift_m[j] = keep * drift_m[j] + std::sqrt(1.0 - keep * keep) * kDrift_m * normal3(random, 0);
        body.state[j] = state_of(spec, pose, take.world_from_sensor[s], s, j, i);
        if (body.state[j] == TrackingState::not_tracked) continue;
        const double factor = body.state[j] == TrackingState::inferred ? kInferredFactor : 1.0;
        const Eigen::Vector3d error_m =
            bias_m(spec, s, j, pose.heading_rad - angle) + drift_m[j] + kJitter_m * normal3(random, 3);
        body.joint_in_sensor_m[j] =
            (sensor_from_world * pose.joint_in_world_m[j] + factor * error_m).cast<float>();
      }
    }
    const std::vector<bool> exchanged = draw_exchanges(spec, s, sees_back);
    for (std::size_t i = 0; i < spec.instants; ++i) {
      if (!exchanged[i]) continue;
      exchange_sides(take.tracks.at(i, s));
      if (spec.toes_follow_labels) turn_toes(take.tracks.at(i, s));
      take.exchanged[i * spec.sensors + s] = 1;
    }
  }
  return take;
}

}  // namespace trilat::testing_support
