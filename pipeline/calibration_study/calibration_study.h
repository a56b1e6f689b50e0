// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "datasets/base/strict_json.h"
#include "datasets/synthetic/simulation_spec.h"
#include "pipeline/study/study.h"

namespace trilat {

// A study of kind "calibration": how well sensors are calibrated from depth images, on simulated ones. Each
// part can be left out by asking for none of it.
struct CalibrationSpec {
  std::string name;
  std::uint64_t seed = 1;
  double ball_radius_m = 0.075;
  // Error of one wand position against distance and angle: so many samples of each of so many units (each
  // with its own depth offset, wiggle and optics), each the mean of so many frames.
  std::uint64_t units = 8;
  std::uint64_t samples = 100;
  std::uint64_t near_samples = 50;  // nearer than 0.5 m
  std::uint64_t frames = 5;
  std::vector<double> distances_m{0.4, 4.5};  // from, to
  double largest_angle_deg = 35.0;            // from the central line
  // A flat wall, of the first units.
  std::uint64_t distortion_units = 8;
  std::uint64_t distortion_frames = 1000;
  double wall_m = 2.0;
  // Whole rigs: so many runs with so many wand positions, each the mean of so many frames.
  RigSpec rig;
  std::uint64_t runs = 200;
  std::uint64_t positions = 50;
  std::uint64_t position_frames = 3;
  double bodies_s = 20.0;               // of walking, for the calibration from bodies
  std::uint64_t bodies_instants = 100;  // at which the bodies are compared
};

CalibrationSpec parse_calibration_spec(const Json& json, const std::string& place);

// Every setting written out, defaults included.
Json resolved_json(CalibrationSpec spec);

// Simulated calibration: one wand position, a flat wall and whole rigs. Its summary.json is a
// CalibrationSummary.
Study calibration_study(const CalibrationSpec& spec);

}  // namespace trilat
