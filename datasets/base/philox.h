// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

namespace trilat {

// Philox4x32-10 of Salmon, Moraes, Dror and Shaw, "Parallel random numbers: as easy as 1, 2, 3" (SC 2011).
std::array<std::uint32_t, 4> philox4x32_10(std::array<std::uint32_t, 4> counter,
                                           std::array<std::uint32_t, 2> key);

// The 53 highest bits of 64 random ones as a number in the open interval (0, 1).
double open_unit(std::uint32_t low, std::uint32_t high);

// Purpose of a random number. A new use gets a new entry at the end: the value is part of the key, so the
// order must not change. The evaluated method is never part of a key: all methods see the same noise.
enum class Purpose : std::uint32_t {
  test = 0,
  participant = 1,
  sensor_clock = 2,
  sensor_drop = 3,
  joint_noise = 4,
  joint_bias = 5,
  joint_state = 6,
  marker_offset = 7,
  marker_noise = 8,
  marker_gap = 9,
  mocap_clock = 10,
  clock_exchange = 11,
  arrival_delay = 12,
  range_trial = 13,
  depth_pixel = 14,
  depth_unit = 15,
  wand_motion = 16,
  wand_sample = 17,
  calibration_trial = 18,
  tracker_bias = 19,
  tracker_drift = 20,
  tracker_jitter = 21,
  tracker_jump = 22,
  tracker_hidden = 23,
  tracker_exchange = 24,
  bootstrap = 27,
  calibration_error = 28,
  tracker_own_bias = 29,
  tracker_hidden_error = 30,
};

// Random numbers as a pure function of (seed, purpose, item, index): no state, no order, no thread.
struct RandomStream {
  std::uint64_t seed = 0;
  Purpose purpose = Purpose::test;
  std::uint64_t item = 0;

  // Uniform in the open interval (0, 1), 53 bits.
  double uniform(std::uint32_t index) const;
  double uniform(std::uint32_t index, double low, double high) const {
    return low + (high - low) * uniform(index);
  }
  // Standard normal by Box and Muller.
  double normal(std::uint32_t index) const;
  // Two independent standard normals from one block; normal(i) is the first of them.
  std::array<double, 2> normal_pair(std::uint32_t index) const;
};

// Packs small counters into one item number: take, unit (sensor, marker), part (joint, axis), step (frame).
// Bounds: take < 2^14, unit < 2^10, part < 2^8, step < 2^32; larger values throw InternalError.
std::uint64_t random_item(std::uint64_t take, std::uint64_t unit, std::uint64_t part, std::uint64_t step);

}  // namespace trilat
