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

constexpr std::uint64_t kMaxSensors = 64;
constexpr double kMinDistance_m = 1e-6;

double decay(double step, double length) { return length > 0.0 ? std::exp(-step / length) : 0.0; }

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
  return {seed, purpose, random_item(take, sensor, part, frame)};
}

RandomStream TrackerKey::body_stream(Purpose purpose, std::uint64_t joint) const {
  return {seed, purpose, random_item(participant, 0, joint, 0)};
}

RandomStream TrackerKey::sensor_stream(Purpose purpose, std::uint64_t joint) const {
  return {seed, purpose, random_item(participant, (sensor + 1) << 4, joint, 0)};
}

TrackerKey TrackerKey::shared_stream() const {
  TrackerKey key = *this;
  key.sensor = kMaxSensors - 1;
  return key;
}

BodyView body_view(const SkeletonPose& pose, const Vector3d& sensor_in_world_m) {
  const double heading = heading_of(pose);
  const Vector3d to_sensor = sensor_in_world_m - middle_of(pose);
  const double forward = std::sin(heading) * to_sensor.x() + std::cos(heading) * to_sensor.z();
  const double left = std::cos(heading) * to_sensor.x() - std::sin(heading) * to_sensor.z();
  return {heading, std::atan2(left, forward), sensor_in_world_m};
}

Vector3d ViewDependentError::seen_from(double azimuth_rad) const {
  return common + own + std::cos(azimuth_rad) * facing + std::sin(azimuth_rad) * beside;
}

JointErrors::JointErrors(const BodyTrackerSpec& spec, double rate_hz, const TrackerKey& key,
                         const DepthUnit& unit)
    : spec_(spec), rate_hz_(rate_hz), key_(key), unit_(unit) {
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const RandomStream bias = key.body_stream(Purpose::tracker_bias, j),
                       hidden = key.body_stream(Purpose::tracker_hidden_error, j);
    joints_[j].bias_m = {of_group(spec.bias_sigma_m, j) * normal_vector(bias, 0),
                         of_group(spec.view_bias_sigma_m, j) * normal_vector(bias, 2),
                         of_group(spec.view_bias_sigma_m, j) * normal_vector(bias, 4),
                         of_group(spec.own_bias_sigma_m, j) *
                             normal_vector(key.sensor_stream(Purpose::tracker_own_bias, j), 0)};
    joints_[j].hidden_m.facing = of_group(spec.inferred_error_sigma_m, j) * normal_vector(hidden, 0);
    joints_[j].hidden_m.beside = of_group(spec.inferred_error_sigma_m, j) * normal_vector(hidden, 2);
  }
}

void JointErrors::restart() {
  for (JointState& state : joints_) state.has_truth = false;
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

// Both parts are scaled so that their squares sum to what they were.
Vector3d JointErrors::along_and_across(const Vector3d& error_m, const Vector3d& ray) const {
  const double ratio = spec_.ray_ratio;
  if (ratio == 1.0) return error_m;
  const double across = std::sqrt(3.0 / (ratio * ratio + 2.0));
  return across * (error_m + (ratio - 1.0) * ray.dot(error_m) * ray);
}

// All sensors draw their common part, and that of the direction of view, from the same numbers.
void JointErrors::drift(JointState& state, std::size_t joint, std::uint64_t frame, double step_m) const {
  const double kept = state.has_drift ? decay(step_m, spec_.drift_path_m) : 0.0;
  state.has_drift = true;
  if (kept == 1.0) return;
  const double fresh = std::sqrt(1.0 - kept * kept);
  const auto renew = [&](Vector3d& part, const BodyTrackerSpec::Groups& sigma_m, const RandomStream& random,
                         std::uint32_t first) {
    if (const double sigma = of_group(sigma_m, joint); sigma > 0.0)
      part = kept * part + fresh * sigma * normal_vector(random, first);
  };
  const RandomStream common = key_.shared_stream().stream(Purpose::tracker_drift, joint, frame);
  renew(state.drift_m.common, spec_.drift_sigma_m, common, 0);
  renew(state.drift_m.facing, spec_.view_drift_sigma_m, common, 2);
  renew(state.drift_m.beside, spec_.view_drift_sigma_m, common, 4);
  renew(state.drift_m.own, spec_.own_drift_sigma_m, key_.stream(Purpose::tracker_drift, joint, frame), 0);
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
  if (hidden && !state.hidden)
    state.reported_as_tracked =
        key_.stream(Purpose::tracker_hidden, joint, frame).uniform(0) < spec_.hidden_as_tracked_share;
  if (!hidden) state.reported_as_tracked = false;
  state.hidden = hidden;
}

std::array<Vector3d, kJointCount> JointErrors::step(std::uint64_t frame, const SkeletonPose& pose,
                                                    const BodyView& view,
                                                    const std::bitset<kJointCount>& hidden) {
  const Eigen::Matrix3d world_from_body =
      Eigen::AngleAxisd(view.heading_rad, Vector3d::UnitY()).toRotationMatrix();
  std::array<Vector3d, kJointCount> seen_m;
  seen_m.fill(Vector3d::Zero());
  for (std::size_t j = 0; j < kJointCount; ++j) {
    JointState& state = joints_[j];
    note_hidden(state, j, frame, hidden[j]);
    const Vector3d jump_m = jump(state, j, frame);
    if (!pose.present[j]) {
      state.has_truth = false;
      continue;
    }
    const Vector3d& truth_m = pose.joint_in_world_m[j];
    drift(state, j, frame, state.has_truth ? (truth_m - state.truth_m).norm() : 0.0);
    Vector3d error_m = world_from_body *
                       (state.bias_m.seen_from(view.azimuth_rad) + state.drift_m.seen_from(view.azimuth_rad));
    if (const double sigma_m = of_group(spec_.jitter_sigma_m, j); sigma_m > 0.0)
      error_m += sigma_m * normal_vector(key_.stream(Purpose::tracker_jitter, j, frame), 0);
    const Vector3d from_sensor_m = truth_m - view.sensor_in_world_m;
    const double range_m = from_sensor_m.norm();
    const Vector3d ray = from_sensor_m / std::max(range_m, kMinDistance_m);
    seen_m[j] = follow(state, truth_m) + jump_m + along_and_across(error_m, ray) +
                spec_.unit_depth_share * unit_.error_m(range_m) * ray;
    if (state.hidden) seen_m[j] += world_from_body * state.hidden_m.seen_from(view.azimuth_rad);
  }
  return seen_m;
}

}  // namespace trilat
