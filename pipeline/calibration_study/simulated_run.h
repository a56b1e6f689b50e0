// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "pipeline/calibration/calibrate_views.h"
#include "pipeline/calibration_study/calibration_spec.h"
#include "pipeline/calibration_study/study_units.h"
#include "pipeline/study/watch.h"

namespace trilat {

// One run of the study: what the sensors saw of the wand, and the truth.
struct SimulatedRun {
  WandViews views;
  std::vector<Eigen::Vector3d> position_in_world_m;  // of the ball, one a position that was seen
  RigidTransform wand_from_world;                    // the frame that the first three places define
  double movement_m = 0.0;                           // from the first to the second
  double measured_movement_m = 0.0;                  // the same with an error of 1 mm
  WandTrack track;                                   // of the ball, as OptiTrack would see it at rest
};
SimulatedRun simulate_run(const CalibrationSpec& spec, const std::vector<RigidTransform>& world_from_sensor,
                          std::uint64_t run, const Watch& watch);

// A recording of bodies only: one person walking, with the declared tracker or one without bias.
void write_walk(const CalibrationSpec& spec, const std::vector<RigidTransform>& world_from_sensor,
                std::uint64_t run, bool with_bias, const std::filesystem::path& session);

}  // namespace trilat
