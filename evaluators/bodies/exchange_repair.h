// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "datasets/rig/rigid_transform.h"
#include "evaluators/bodies/observed_body.h"

namespace trilat {

// All weights are logarithms of odds.
struct ExchangeOptions {
  double instant_s = 1.0 / 30.0;  // between two instants of the tracks
  // Tracker errors stay for about this long: evidence of shape counts once in it, not once a frame.
  double evidence_time_s = 1.0;
  double switching_cost = 6.0;  // of a sensor that begins or ends to exchange, beside what its joints say
  // Cost of each exchanged instant; decides takes without other evidence. With one sensor there is no second
  // opinion: more.
  double prior_log_odds = 0.002;
  double prior_log_odds_alone = 0.08;
  // Log odds of the whole sequence against its opposite (left is right everywhere); below it nothing is
  // repaired.
  double min_log_odds = 10.0;
};

// At which instants which sensors give left joints as right ones.
struct SideSwapRepair {
  std::size_t sensors = 0;
  std::vector<std::uint8_t> sides_swapped;  // instants x sensors, instant by instant; 1 where exchanged
  std::vector<std::size_t>
      stretches;  // one a sensor: runs of exchanged bodies, missing ones in between or not

  bool at(std::size_t instant, std::size_t sensor) const {
    return sides_swapped[instant * sensors + sensor] != 0;
  }
};

// The most likely course of exchanges over the take, all sensors at once (Viterbi over the 2^sensors states).
// Weighs that sensors agree on left and right, that left and right do not jump in time, that toes, knees and
// hands are before the body's parts they belong to, and elbows behind. The world is y up; instants follow
// each other at equal times. A sensor without a body is never exchanged. InternalError unless every sensor
// has one pose and the rig is within kMaxSensors.
[[nodiscard]] SideSwapRepair find_exchanges(const BodyTracks& tracks,
                                            std::span<const RigidTransform> world_from_sensor,
                                            const ExchangeOptions& options);

// Gives every exchanged body its joints back: position and state of each joint and its mirror_of are swapped.
// Doing it twice undoes it. InternalError when the two differ in size.
void undo_exchanges(BodyTracks& tracks, const SideSwapRepair& repair);

}  // namespace trilat
