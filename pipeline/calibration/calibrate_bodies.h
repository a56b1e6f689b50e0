// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "datasets/rig/calibration.h"

namespace trilat {

struct CalibrateBodiesOptions {
  std::size_t instants = 100;   // spread evenly over the recording
  double longest_gap_s = 0.11;  // between two frames of a sensor that are interpolated
  // Standard deviation of a tracked joint, an axis: 3 cm of bias and 1.5 cm of noise.
  double joint_sigma_m = 0.0335;
  // Standard deviation of a unit's depth error, which all its joints share: it is uniform within 2.4 cm to
  // both sides (docs/explanation/simulator.md).
  double unit_depth_sigma_m = 0.0139;
  double robust_scale = 2.0;  // soft-L1 loss, in standard deviations
  std::function<bool()> stop_requested = {};
};

struct BodyCalibration {
  Calibration calibration;
  std::size_t reference = 0;            // the sensor whose pose is the world; it has no uncertainty
  std::vector<std::string> notes = {};  // joints that were not used, by sensor
};

// Sensor poses from one person whom several sensors tracked at the same time, for people without a wand. The
// world is the best seen sensor's, moved to the floor below it and levelled by its floor plane: y up, z
// horizontally out of the lens. Trackers see each joint a little off, differently from every side, and time
// does not average that out: the stated uncertainty is a jackknife over joints (each left out in turn, and
// the rest refined again), which contains it, and the depth error of each unit, which it does not. InputError
// says which sensor cannot be placed and why.
BodyCalibration calibrate_bodies(const std::filesystem::path& session, const CalibrateBodiesOptions& options);

}  // namespace trilat
