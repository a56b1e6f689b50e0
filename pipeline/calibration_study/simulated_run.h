// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "datasets/depth/depth_rays.h"
#include "datasets/synthetic/depth/depth_renderer.h"
#include "pipeline/calibration/calibrate_views.h"
#include "pipeline/calibration_study/calibration_study.h"
#include "pipeline/study/watch.h"

namespace trilat {

// One simulated Kinect of the study, as what it renders with and what its depth is read with.
struct StudyUnit {
  DepthUnit depth;
  DepthRays rays;
  DepthRenderer renderer;
};

// Optics and depth errors are functions of the seed and the unit's number; the declared noise model.
StudyUnit draw_study_unit(std::uint64_t seed, std::uint64_t unit);

// One run of the study: what the sensors saw of the wand, and the truth.
struct SimulatedRun {
  WandViews views;
  std::vector<Eigen::Vector3d> position_in_world_m;  // of the ball, one a position that was seen
  RigidTransform wand_from_world;                    // the frame that the first three places define
  double movement_m = 0.0;                           // from the first to the second
};
SimulatedRun simulate_run(const CalibrationSpec& spec, const std::vector<RigidTransform>& world_from_sensor,
                          std::uint64_t run, const Watch& watch);

// A recording of bodies only: one person walking.
void write_walk(const CalibrationSpec& spec, const std::vector<RigidTransform>& world_from_sensor,
                std::uint64_t run, const BodyTrackerSpec& tracker, const std::filesystem::path& session);

}  // namespace trilat
