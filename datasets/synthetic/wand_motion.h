// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "datasets/synthetic/depth/room_scene.h"
#include "datasets/synthetic/generated_person.h"

namespace trilat {

// A calibration recording: a ball is held still at one position after another, and moved smoothly between.
struct WandMotionSpec {
  std::uint64_t positions = 50;  // at least 3
  double hold_s = 1.0;
  double move_s = 0.8;
};

struct WandHold {
  Eigen::Vector3d ball_in_world_m;
  double from_s, to_s;
};

struct WandInstant {
  Eigen::Vector3d ball_in_world_m;
  Eigen::Vector3d stick_direction;  // from the ball's centre to the hand that holds the stick; unit
  SkeletonPose person;
  bool is_held = true;  // false: it hangs free, and no person is in the room
};

// The ball with its stick and, where somebody holds it and is shown, the person.
void append_wand_instant(DepthScene& scene, const WandInstant& instant, const WandShape& shape,
                         bool shows_person);

// The first three positions define a frame of their own: 1 m high on one side of the middle of the rig; 1.2
// to 1.4 m from it on the other side, at the same height; 0.6 m above the first. The others are anywhere in a
// cylinder about the middle, 0.9 m wide each way and from 0.4 to 1.7 m high, so that several sensors see most
// of them. Somebody stands 1.2 m beside the ball (a quarter of a turn on), faces it and holds the stick in
// the right hand. Until the end of the third position the wand hangs free without a person, so that all
// sensors see the places that define the world.
class WandMotion {
 public:
  WandMotion(const WandMotionSpec& spec, std::uint64_t seed, const Eigen::Vector3d& rig_centre_in_world_m,
             const Person& person);

  double duration_s() const { return holds_.back().to_s; }
  const std::vector<WandHold>& holds() const { return holds_; }
  // At any time and in any order; before the start and after the end the ball is held.
  WandInstant at(double time_s) const;

 private:
  struct HeldPose;
  HeldPose held_pose_at(double time_s) const;

  WandMotionSpec spec_;
  Eigen::Vector3d centre_m_;
  Motion standing_;
  std::vector<WandHold> holds_;
  std::vector<double> bearing_rad_;  // of each position from the middle, from +z towards +x, without jumps
};

}  // namespace trilat
