// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "datasets/base/time.h"
#include "datasets/session/session_reader.h"
#include "evaluators/calibration/wand_positions.h"
#include "evaluators/ceres/rig_refinement.h"

namespace trilat {

// The floor as the body tracker states it: its unit normal and how high the sensor hangs above it.
struct FloorPlane {
  Eigen::Vector3d up_in_sensor = Eigen::Vector3d::UnitY();
  double height_m = 0.0;
};

// From the first of some hundred body frames, spread over the session, that has one.
std::optional<FloorPlane> floor_seen_by(const SessionReader& session, std::size_t sensor);

// Path of the wand's ball in an OptiTrack export, in the order of time.
struct WandTrack {
  std::vector<MocapTime> times;
  std::vector<Eigen::Vector3d> position_m;  // one a time
};

// An OptiTrack export of the wand, which ties the calibration to OptiTrack's world.
struct WandInWorld {
  std::filesystem::path mocap;
  std::string asset;  // whose position is the ball's centre
  std::int64_t mocap_start_host_ns = 0;
  // Standard deviation of a place, an axis, beside its samples' scatter: from OptiTrack's own calibration,
  // which states +-0.1 mm for its best cameras.
  double sigma_m = 0.0001;
  std::optional<WandTrack> track = std::nullopt;  // read from the export where it is not here
};

// InputError when the export has no such asset, or not its position.
WandTrack read_wand_track(const std::filesystem::path& mocap, const std::string& asset);

// Positions of the resting wand by OptiTrack: the mean over each position's interval, as sure as its
// samples and `sigma_m` say. Positions that the export does not cover, or at which the asset moved by more
// than 5 mm, are left out. InputError when fewer than three are left.
std::vector<ControlPoint> known_positions(const WandInWorld& world, std::span<const WandPosition> positions);

}  // namespace trilat
