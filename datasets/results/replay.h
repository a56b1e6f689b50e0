// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/geometry/rigid_transform.h"

namespace trilat {

// What a replay shows at most of one take.
inline constexpr double kReplay_s = 35.0;

// What the sensors saw during the first part of a take, which samples.h5 does not tell. Its truth and
// estimates are rows [0, instants) of that take there.
struct ReplayTake {
  std::string id, condition;
  std::vector<std::string> sensors;
  std::vector<RigidTransform> world_from_sensor;
  std::uint64_t instants = 0;
  // x, y, z in the world of every instant, sensor and Kinect joint; NaN where the sensor does not have it.
  // Exchanges of left and right that the study undoes are undone.
  std::vector<float> joint_m;
  std::vector<std::uint8_t> state;  // TrackingState of the same

  // Takes up the shape and says "not seen" everywhere.
  void reset(std::uint64_t instants, std::size_t sensors);
};

// replay.h5 (version 2) beside samples.h5 in the item of a take. Equal takes give equal bytes.
void write_replay(const std::filesystem::path& folder, const ReplayTake& take);
// Nothing when there is no such file; InputError when it is not one of these.
std::optional<ReplayTake> read_replay(const std::filesystem::path& folder);

}  // namespace trilat
