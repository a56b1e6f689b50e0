// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace trilat {

// Place of the joint of a trial, in the world.
enum class TrialJoint : std::uint8_t {
  centre,  // (0, 1, 0) m, every time
  volume,  // uniform where a body moves: x, z within 0.6 m of the middle, y from 0.1 to 1.9 m
};

// How wrong each sensor is; every sensor on its own.
enum class TrialError : std::uint8_t {
  range_signed,  // |range error| uniform from low to high, either sign with probability 1/2
  displacement,  // it sees the joint displaced: length uniform from low to high, direction uniform on the
                 // sphere
  gaussian,      // normal range error whose mean magnitude is (low + high) / 2: sigma = that * sqrt(pi / 2)
};

// Trials of one cell. Random numbers are those of RandomStream{seed, Purpose::range_trial, trial}: they do
// not depend on the sensors, and on the error range by scaling only.
struct RangeTrialModel {
  static constexpr int kMaxSensors = 8;
  std::uint64_t seed = 0;
  int sensors = 0;
  std::array<std::array<double, 3>, kMaxSensors> sensor_m{};  // world
  TrialJoint joint = TrialJoint::volume;
  TrialError error = TrialError::range_signed;
  double low_m = 0.0, high_m = 0.0;
};

// Arrays that trials are written into: trial i of the call in column i, rows `stride` apart.
struct RangeTrialRows {
  std::size_t stride = 0;
  double* truth_m = nullptr;  // 3 rows: x, y, z
  double* range_m = nullptr;  // a row a sensor; never negative
  // 3 rows, or null: the mean of the joint as the sensors see it, each displaced. For error models without
  // displaced joints it is drawn as if they were `displacement`.
  double* mean_m = nullptr;
};

// Columns are written in blocks: rows must have room for `count` rounded up to this.
inline constexpr std::size_t kTrialBlock = 8;

// Makes the trials first_trial … first_trial + count - 1 by the widest vectors of this processor; every width
// gives the same bits.
void make_range_trials(const RangeTrialModel& model, std::uint64_t first_trial, std::size_t count,
                       const RangeTrialRows& rows);

// Which index of a trial's RandomStream is drawn for what.
namespace trial_index {
inline constexpr std::uint32_t kJoint = 0;      // x, y, z of `volume`
inline constexpr std::uint32_t kSensor = 8;     // of the first sensor
inline constexpr std::uint32_t kPerSensor = 4;  // length, height, azimuth, range error
inline constexpr std::uint32_t kRangeError = 3;
}  // namespace trial_index

}  // namespace trilat
