// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <span>
#include <vector>

#include "datasets/session/body_readings.h"
#include "datasets/session/clock/session_clock.h"
#include "datasets/session/session_reader.h"
#include "evaluators/bodies/observed_body.h"

namespace trilat {

struct IdentifiedBody {
  std::uint64_t identity = 0;  // tracking id, or a number of its own after a jump: BodyIdentities
  ObservedBody body;
};

// Everybody whom one sensor sees at one time.
struct SensorFrame {
  HostTime time;     // of exposure
  HostTime arrived;  // at its machine, on the host clock
  std::span<const IdentifiedBody> bodies;
};

// All bodies that one sensor sees in a session. Moved and not copied: frames refer to the bodies.
struct SensorBodies {
  SensorBodies() = default;
  SensorBodies(SensorBodies&&) = default;
  SensorBodies& operator=(SensorBodies&&) = default;

  std::vector<SensorFrame> frames;
  std::vector<IdentifiedBody> bodies;  // of all frames, in one piece: an hour has a hundred thousand
  JointFaults joints;
  std::uint64_t jumps = 0;      // bodies that became others under one tracking id
  std::uint64_t stale = 0;      // bodies that were left out because the sensor gave them again
  std::uint64_t not_later = 0;  // frames that were left out because their time does not rise
};

// All body frames of a sensor. Those whose time does not rise are left out. Throws Interrupted when asked to
// stop.
SensorBodies read_sensor_bodies(const SessionReader& session, std::size_t sensor,
                                const SensorClockMap& host_from_sensor,
                                const std::function<bool()>& stop_requested);

// One person at any time. A joint is interpolated linearly between two frames that both see it and are no
// farther apart than `longest_gap`; its state is the worse of the two. Of several bodies in a frame the one
// with the most tracked joints is taken (the first of equals), of those with a wanted identity when `wanted`
// is given.
ObservedBody body_at(std::span<const SensorFrame> frames, HostTime t, Duration longest_gap,
                     const std::set<std::uint64_t>* wanted = nullptr);

// The person in the newest frame that had arrived by `t`, held for `longest_gap` from its exposure. Frames
// that arrived more than `late` after their exposure are dropped. The paper's server drops late frames,
// without saying from which moment on it counts; 33 ms is what it calls real time.
ObservedBody newest_body(std::span<const SensorFrame> frames, HostTime t, Duration longest_gap, Duration late,
                         const std::set<std::uint64_t>* wanted = nullptr);

}  // namespace trilat
