// SPDX-License-Identifier: MIT
#include "datasets/synthetic/wand_motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "datasets/base/error.h"
#include "datasets/base/philox.h"

namespace trilat {
namespace {

using Eigen::Vector3d;

constexpr double kMaxDistance_m = 0.9, kLowest_m = 0.4, kHighest_m = 1.7;
constexpr double kPersonToBall_m = 1.2;
constexpr std::size_t kDefining = 3;  // positions that define a frame

Vector3d horizontal(double bearing_rad) { return {std::sin(bearing_rad), 0.0, std::cos(bearing_rad)}; }

// From 0 to 1 without speed and acceleration at either end.
double share_of_way(double share) { return share * share * share * (10.0 + share * (6.0 * share - 15.0)); }

std::vector<Vector3d> positions_of(std::uint64_t count, std::uint64_t seed, const Vector3d& centre_m) {
  std::vector<Vector3d> positions;
  for (std::uint64_t i = 0; i < count; ++i) {
    const RandomStream random{seed, Purpose::wand_motion, i};
    const double bearing_rad = random.uniform(0, 0.0, (2.0 * std::numbers::pi));
    const double share = random.uniform(1), height_share = random.uniform(2);
    if (i == 0) {
      positions.push_back(centre_m + (0.6 + 0.1 * share) * horizontal(bearing_rad));
      positions.back().y() = 0.95 + 0.1 * height_share;
    } else if (i == 1) {
      const Vector3d from_centre = positions[0] - centre_m;
      positions.push_back(centre_m -
                          (0.6 + 0.1 * share) * Vector3d(from_centre.x(), 0.0, from_centre.z()).normalized());
      positions.back().y() = positions[0].y();  // level, as the paper's movement
    } else if (i == 2) {
      positions.push_back(positions[0] + Vector3d(0.0, 0.6, 0.0));
    } else {
      positions.push_back(centre_m + kMaxDistance_m * std::sqrt(share) * horizontal(bearing_rad));
      positions.back().y() = kLowest_m + (kHighest_m - kLowest_m) * height_share;
    }
  }
  return positions;
}

// The right arm reaches for a point: the hand is there, the elbow hangs a little below the line.
void reach(SkeletonPose& pose, const Vector3d& hand_m) {
  const Vector3d shoulder = pose.at(Joint::shoulder_right);
  const Vector3d forearm = (hand_m - shoulder).normalized();
  const Vector3d elbow = 0.5 * (shoulder + hand_m) - Vector3d(0.0, 0.08, 0.0);
  pose.at(Joint::elbow_right) = elbow;
  pose.at(Joint::wrist_right) = hand_m - 0.08 * (hand_m - elbow).normalized();
  pose.at(Joint::hand_right) = hand_m;
  pose.at(Joint::hand_tip_right) = hand_m + 0.06 * forearm;
  pose.at(Joint::thumb_right) = hand_m + Vector3d(0.0, 0.04, 0.0);
}

}  // namespace

void append_wand_instant(DepthScene& scene, const WandInstant& instant, const WandShape& shape,
                         bool shows_person) {
  if (shows_person && instant.is_held) append_person(scene, instant.person);
  if (instant.is_held)
    append_wand(scene, instant.ball_in_world_m, instant.stick_direction, shape);
  else
    scene.spheres.push_back({instant.ball_in_world_m, shape.ball_radius_m});
}

// Place of the ball, and direction from the middle to the person.
struct WandMotion::HeldPose {
  Vector3d ball_m;
  double bearing_rad;
};

WandMotion::WandMotion(const WandMotionSpec& spec, std::uint64_t seed, const Vector3d& rig_centre_in_world_m,
                       const Person& person)
    : spec_(spec), centre_m_(rig_centre_in_world_m), standing_(generated_motion(person, Activity::standing)) {
  TRILAT_CHECK(spec.positions >= kDefining && spec.hold_s > 0.0 && spec.move_s > 0.0,
               "a wand has a frame to show");
  double start_s = 0.0;
  for (const Vector3d& ball : positions_of(spec.positions, seed, centre_m_)) {
    holds_.push_back({ball, start_s, start_s + spec.hold_s});
    start_s += spec.hold_s + spec.move_s;
    const double bearing = std::atan2(ball.x() - centre_m_.x(), ball.z() - centre_m_.z());
    const double before = bearing_rad_.empty() ? bearing : bearing_rad_.back();
    bearing_rad_.push_back(before + std::remainder(bearing - before, (2.0 * std::numbers::pi)));
  }
}

WandMotion::HeldPose WandMotion::held_pose_at(double time_s) const {
  const double last = static_cast<double>(holds_.size() - 1);
  const double cycle = std::clamp(std::floor(time_s / (spec_.hold_s + spec_.move_s)), 0.0, last);
  const auto i = static_cast<std::size_t>(cycle);
  if (time_s <= holds_[i].to_s || i + 1 == holds_.size()) return {holds_[i].ball_in_world_m, bearing_rad_[i]};
  const double share = share_of_way(std::min(1.0, (time_s - holds_[i].to_s) / spec_.move_s));
  const Vector3d& from = holds_[i].ball_in_world_m;
  return {from + share * (holds_[i + 1].ball_in_world_m - from),
          bearing_rad_[i] + share * (bearing_rad_[i + 1] - bearing_rad_[i])};
}

WandInstant WandMotion::at(double time_s) const {
  const HeldPose stand = held_pose_at(time_s);
  // A quarter of a turn on from the ball, seen from the middle: nobody stands in front of the nearest sensor.
  // Turned as the ball goes round, so that passing the middle does not turn the person about.
  const double beside_rad = stand.bearing_rad + 0.5 * std::numbers::pi;
  const Vector3d beside = horizontal(beside_rad);
  Vector3d feet = stand.ball_m + kPersonToBall_m * beside;
  feet.y() = 0.0;
  const double heading_rad = beside_rad + std::numbers::pi;
  const Eigen::AngleAxisd turn(heading_rad, Vector3d::UnitY());
  WandInstant instant{stand.ball_m, {}, standing_(time_s), time_s > holds_[kDefining - 1].to_s};
  instant.person.heading_rad = heading_rad;
  for (Vector3d& joint : instant.person.joint_in_world_m) joint = turn * joint + feet;
  // The hand waits before the right hip, so that the stick passes beside the body.
  const Vector3d left(std::cos(heading_rad), 0.0, -std::sin(heading_rad));
  const double grip_height_m = 1.05 + 0.3 * (stand.ball_m.y() - 1.05);
  const Vector3d grip = feet - 0.40 * beside - 0.28 * left + Vector3d(0.0, grip_height_m, 0.0);
  instant.stick_direction = (grip - stand.ball_m).normalized();
  reach(instant.person, grip);
  return instant;
}

}  // namespace trilat
