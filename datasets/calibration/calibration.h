// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/base/strict_json.h"
#include "datasets/geometry/rigid_transform.h"

namespace trilat {

// Where a sensor stands: its pose in the world, and how sure that is (one standard deviation; 0
// when exact).
struct SensorPose {
  std::string name;
  RigidTransform world_from_sensor;
  double position_sigma_m = 0.0;
  double rotation_sigma_rad = 0.0;
};

// calibration.json, format 1. `method` says how it was made ("simulated truth", "wand", …).
struct Calibration {
  std::string method;
  std::vector<SensorPose> sensors;
};

// Refuses what cannot be: sensors named twice, quaternions that are not unit (beyond 1e-3),
// positions beyond 100 m.
Calibration read_calibration(const std::filesystem::path& path);
void write_calibration(const std::filesystem::path& path, const Calibration& calibration);

// The pose of `name`; InputError at `place` listing the calibrated sensors.
const SensorPose& pose_of(const Calibration& calibration, const std::string& name, const std::string& place);

}  // namespace trilat
