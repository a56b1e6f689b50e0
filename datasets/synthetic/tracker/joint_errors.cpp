// SPDX-License-Identifier: MIT
#include "datasets/synthetic/tracker/joint_errors.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace trilat {
namespace {

using Eigen::Vector3d;

// Three standard normals from two blocks.
Vector3d normal_vector(const RandomStream& random, std::uint32_t first) {
  const auto xy = random.normal_pair(first);
  return {xy[0], xy[1], random.normal(first + 1)};
}

double of_group(const BodyTrackerSpec::Groups& groups, std::size_t joint) {
  return groups[static_cast<std::size_t>(tracker_group_of(static_cast<Joint>(joint)))];
}

double decay(double step_s, double time_s) { return time_s > 0.0 ? std::exp(-step_s / time_s) : 0.0; }

bool has(const SkeletonPose& pose, Joint joint) { return pose.present[static_cast<std::size_t>(joint)]; }

double heading_of(const SkeletonPose& pose) {
  if (pose.heading_rad != 0.0) return pose.heading_rad;
  for (const Joint left : {Joint::shoulder_left, Joint::hip_left}) {
    if (!has(pose, left) || !has(pose, mirror_of(left))) continue;
    const Vector3d to_left = pose.at(left) - pose.at(mirror_of(left));
    return std::atan2(-to_left.z(), to_left.x());
  }
  return 0.0;
}

Vector3d middle_of(const SkeletonPose& pose) {
  if (has(pose, Joint::spine_base) || pose.present.none()) return pose.at(Joint::spine_base);
  Vector3d sum = Vector3d::Zero();
  for (std::size_t j = 0; j < kJointCount; ++j)
    if (pose.present[j]) sum += pose.joint_in_world_m[j];
  return sum / static_cast<double>(pose.present.count());
}

}  // namespace

RandomStream TrackerKey::stream(Purpose purpose, std::uint64_t part, std::uint64_t frame) const {
  return {seed, purpose, random_item(take, person << 6 | sensor, part, frame)};
}

RandomStream TrackerKey::body_stream(Purpose purpose, std::uint64_t joint) const {
  return {seed, purpose, random_item(participant, person, joint, person == 0 ? 0 : take)};
}

BodyView body_view(const SkeletonPose& pose, const Vector3d& sensor_in_world_m) {
  const double heading = heading_of(pose);
  const Vector3d to_sensor = sensor_in_world_m - middle_of(pose);
  const double forward = std::sin(heading) * to_sensor.x() + std::cos(heading) * to_sensor.z();
  const double left = std::cos(heading) * to_sensor.x() - std::sin(heading) * to_sensor.z();
  return {heading, std::atan2(left, forward)};
}

JointErrors::JointErrors(const BodyTrackerSpec& spec, double rate_hz, const TrackerKey& key)
    : spec_(spec), rate_hz_(rate_hz), key_(key) {
  const double landmark = std::sqrt(1.0 - spec.viewpoint_share), viewpoint = std::sqrt(spec.viewpoint_share);
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const double sigma_m = of_group(spec.bias_sigma_m, j);
    const RandomStream random = key.body_stream(Purpose::tracker_bias, j);
    joints_[j].landmark_m = landmark * sigma_m * normal_vector(random, 0);
    joints_[j].facing_m = viewpoint * sigma_m * normal_vector(random, 2);
    joints_[j].beside_m = viewpoint * sigma_m * normal_vector(random, 4);
  }
}

// A first-order filter of what goes straight from one frame to the next: exact on a steady motion, which it
// follows lag_s later.
Vector3d JointErrors::follow(JointState& state, const Vector3d& truth_m) const {
  if (spec_.lag_s == 0.0 || !state.has_truth) {
    state.lagged_m = truth_m;
  } else {
    const double step_s = 1.0 / rate_hz_, kept = decay(step_s, spec_.lag_s);
    const double late = (1.0 - kept) * spec_.lag_s / step_s;
    state.lagged_m = kept * state.lagged_m + (1.0 - late) * truth_m + (late - kept) * state.truth_m;
  }
  state.truth_m = truth_m;
  state.has_truth = true;
  return state.lagged_m;
}

Vector3d JointErrors::random_part(JointState& state, std::size_t joint, std::uint64_t frame) const {
  const double factor = state.hidden ? 1.0 + spec_.inferred_noise_increase : 1.0;
  Vector3d error_m = Vector3d::Zero();
  if (const double sigma_m = of_group(spec_.wander_sigma_m, joint); sigma_m > 0.0) {
    const double kept = state.has_wander ? decay(1.0 / rate_hz_, of_group(spec_.wander_time_s, joint)) : 0.0;
    state.wander =
        kept * state.wander +
        std::sqrt(1.0 - kept * kept) * normal_vector(key_.stream(Purpose::tracker_wander, joint, frame), 0);
    state.has_wander = true;
    error_m += factor * sigma_m * state.wander;
  }
  if (const double sigma_m = of_group(spec_.jitter_sigma_m, joint); sigma_m > 0.0)
    error_m += factor * sigma_m * normal_vector(key_.stream(Purpose::tracker_jitter, joint, frame), 0);
  return error_m;
}

Vector3d JointErrors::jump(JointState& state, std::size_t joint, std::uint64_t frame) const {
  const double rate_hz = of_group(spec_.jump_rate_per_minute, joint) / 60.0;
  if (rate_hz == 0.0 || spec_.jump_size_m == 0.0 || spec_.jump_duration_s == 0.0) return Vector3d::Zero();
  if (frame < state.jump_end) return state.jump_m;
  const RandomStream random = key_.stream(Purpose::tracker_jump, joint, frame);
  if (random.uniform(0) >= rate_hz / rate_hz_) return Vector3d::Zero();
  state.jump_m = spec_.jump_size_m * normal_vector(random, 1).normalized();
  state.jump_end =
      frame + static_cast<std::uint64_t>(std::max(1l, std::lround(spec_.jump_duration_s * rate_hz_)));
  return state.jump_m;
}

void JointErrors::note_hidden(JointState& state, std::size_t joint, std::uint64_t frame, bool hidden) const {
  if (hidden && !state.hidden) {
    const RandomStream random = key_.stream(Purpose::tracker_hidden, joint, frame);
    state.said_to_be_tracked = random.uniform(0) < spec_.hidden_as_tracked_share;
    state.hidden_error_m = spec_.inferred_error_sigma_m * normal_vector(random, 1);
  }
  if (!hidden) state.said_to_be_tracked = false;
  state.hidden = hidden;
}

std::array<Vector3d, kJointCount> JointErrors::step(std::uint64_t frame, const SkeletonPose& pose,
                                                    const BodyView& view,
                                                    const std::bitset<kJointCount>& hidden) {
  const Eigen::AngleAxisd world_from_body(view.heading_rad, Vector3d::UnitY());
  std::array<Vector3d, kJointCount> seen_m;
  seen_m.fill(Vector3d::Zero());
  for (std::size_t j = 0; j < kJointCount; ++j) {
    JointState& state = joints_[j];
    note_hidden(state, j, frame, hidden[j]);
    const Vector3d error_m = random_part(state, j, frame) + jump(state, j, frame);
    if (!pose.present[j]) {
      state.has_truth = false;
      continue;
    }
    const Vector3d bias_m = state.landmark_m + std::cos(view.azimuth_rad) * state.facing_m +
                            std::sin(view.azimuth_rad) * state.beside_m;
    seen_m[j] = follow(state, pose.joint_in_world_m[j]) + world_from_body * bias_m + error_m;
    if (state.hidden) seen_m[j] += state.hidden_error_m;
  }
  return seen_m;
}

}  // namespace trilat
