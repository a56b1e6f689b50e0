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

constexpr std::uint64_t kMostSensors = 64;
constexpr double kNearest_m = 1e-6;

// Spine and head, the arms, the legs.
std::size_t limb_of(Joint joint) {
  switch (tracker_group_of(joint)) {
    case TrackerGroup::trunk:
    case TrackerGroup::head:
      return 0;
    case TrackerGroup::shoulder:
    case TrackerGroup::elbow:
    case TrackerGroup::wrist:
    case TrackerGroup::hand:
    case TrackerGroup::hand_tip:
      return name_of(joint).ends_with("left") ? 1 : 2;
    case TrackerGroup::hip:
    case TrackerGroup::knee:
    case TrackerGroup::ankle:
    case TrackerGroup::foot:
      return name_of(joint).ends_with("left") ? 3 : 4;
  }
  return 0;
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

RandomStream TrackerKey::sensor_stream(Purpose purpose, std::uint64_t joint) const {
  return {seed, purpose, random_item(participant, (sensor + 1) << 4 | person, joint, person == 0 ? 0 : take)};
}

TrackerKey TrackerKey::of_all_sensors() const {
  TrackerKey key = *this;
  key.sensor = kMostSensors - 1;
  return key;
}

BodyView body_view(const SkeletonPose& pose, const Vector3d& sensor_in_world_m) {
  const double heading = heading_of(pose);
  const Vector3d to_sensor = sensor_in_world_m - middle_of(pose);
  const double forward = std::sin(heading) * to_sensor.x() + std::cos(heading) * to_sensor.z();
  const double left = std::cos(heading) * to_sensor.x() - std::sin(heading) * to_sensor.z();
  return {heading, std::atan2(left, forward), sensor_in_world_m};
}

JointErrors::JointErrors(const BodyTrackerSpec& spec, double rate_hz, const TrackerKey& key,
                         const DepthUnit& unit)
    : spec_(spec), rate_hz_(rate_hz), key_(key), unit_(unit) {
  const double landmark = std::sqrt(std::max(0.0, 1.0 - spec.viewpoint_share - spec.own_bias_share)),
               viewpoint = std::sqrt(spec.viewpoint_share), own = std::sqrt(spec.own_bias_share);
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const double sigma_m = of_group(spec.bias_sigma_m, j);
    const RandomStream random = key.body_stream(Purpose::tracker_bias, j);
    joints_[j].fixed_m = sigma_m * (landmark * normal_vector(random, 0) +
                                    own * normal_vector(key.sensor_stream(Purpose::tracker_own_bias, j), 0));
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

Vector3d JointErrors::bias(const JointState& state, const BodyView& view) const {
  const double angle_rad = spec_.viewpoint_harmonic * view.azimuth_rad;
  return Eigen::AngleAxisd(view.heading_rad, Vector3d::UnitY()) *
         (state.fixed_m + std::cos(angle_rad) * state.facing_m + std::sin(angle_rad) * state.beside_m);
}

Vector3d JointErrors::noise(Purpose purpose, std::size_t joint, std::uint64_t frame,
                            double limb_share) const {
  const auto of_key = [&](const TrackerKey& key) {
    Vector3d value = std::sqrt(1.0 - limb_share) * normal_vector(key.stream(purpose, joint, frame), 0);
    if (limb_share > 0.0)
      value += std::sqrt(limb_share) *
               normal_vector(key.stream(purpose, kJointCount + limb_of(static_cast<Joint>(joint)), frame), 0);
    return value;
  };
  const double shared = spec_.shared_wander_share;
  if (shared == 0.0) return of_key(key_);
  return std::sqrt(1.0 - shared) * of_key(key_) + std::sqrt(shared) * of_key(key_.of_all_sensors());
}

// Both parts are scaled so that their squares sum to what they were.
Vector3d JointErrors::along_and_across(const Vector3d& error_m, const Vector3d& ray) const {
  const double ratio = spec_.ray_ratio;
  if (ratio == 1.0) return error_m;
  const double across = std::sqrt(3.0 / (ratio * ratio + 2.0));
  return across * (error_m + (ratio - 1.0) * ray.dot(error_m) * ray);
}

Vector3d JointErrors::random_part(JointState& state, std::size_t joint, std::uint64_t frame) const {
  const double factor = state.hidden ? 1.0 + spec_.inferred_noise_increase : 1.0;
  Vector3d error_m = Vector3d::Zero();
  if (const double sigma_m = of_group(spec_.wander_sigma_m, joint); sigma_m > 0.0) {
    const double kept = state.has_wander ? decay(1.0 / rate_hz_, of_group(spec_.wander_time_s, joint)) : 0.0;
    state.wander = kept * state.wander + std::sqrt(1.0 - kept * kept) * noise(Purpose::tracker_wander, joint,
                                                                              frame, spec_.limb_correlation);
    state.has_wander = true;
    error_m += factor * sigma_m * state.wander;
  }
  if (const double sigma_m = of_group(spec_.jitter_sigma_m, joint); sigma_m > 0.0)
    error_m += factor * sigma_m * noise(Purpose::tracker_jitter, joint, frame, 0.0);
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

double JointErrors::growth(const BodyView& view, double range_m) const {
  constexpr double kUsualRange_m = 2.0;
  return (1.0 + spec_.azimuth_growth * 0.5 * (1.0 - std::cos(view.azimuth_rad))) *
         (1.0 + spec_.range_growth_per_m * std::max(0.0, range_m - kUsualRange_m));
}

std::array<Vector3d, kJointCount> JointErrors::step(std::uint64_t frame, const SkeletonPose& pose,
                                                    const BodyView& view,
                                                    const std::bitset<kJointCount>& hidden) {
  std::array<Vector3d, kJointCount> seen_m;
  seen_m.fill(Vector3d::Zero());
  for (std::size_t j = 0; j < kJointCount; ++j) {
    JointState& state = joints_[j];
    note_hidden(state, j, frame, hidden[j]);
    const Vector3d random_m = random_part(state, j, frame), jump_m = jump(state, j, frame);
    if (!pose.present[j]) {
      state.has_truth = false;
      continue;
    }
    const Vector3d from_sensor_m = pose.joint_in_world_m[j] - view.sensor_in_world_m;
    const double range_m = from_sensor_m.norm();
    const Vector3d ray = from_sensor_m / std::max(range_m, kNearest_m);
    seen_m[j] = follow(state, pose.joint_in_world_m[j]) + jump_m +
                along_and_across(bias(state, view) + growth(view, range_m) * random_m, ray) +
                spec_.unit_depth_share * unit_.error_m(range_m) * ray;
    if (state.hidden) seen_m[j] += state.hidden_error_m;
  }
  return seen_m;
}

}  // namespace trilat
