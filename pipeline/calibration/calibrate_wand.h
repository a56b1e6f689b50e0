// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/calibration/calibration.h"
#include "evaluators/ceres/rig_refinement.h"
#include "pipeline/calibration/wand_search.h"

namespace trilat {

// An OptiTrack export of the wand, which ties the calibration to OptiTrack's world.
struct WandInWorld {
  std::filesystem::path mocap;
  std::string asset;  // whose position is the ball's centre
  std::int64_t mocap_start_host_ns = 0;
  double sigma_m = 0.001;
};

struct CalibrateWandOptions {
  WandSearchOptions search;
  WandPositionOptions positions;
  std::vector<std::pair<std::string, std::filesystem::path>> intrinsics = {};  // sensor and OpenCV file
  std::optional<WandInWorld> world = std::nullopt;
  std::optional<double> movement_m = std::nullopt;  // from the first place to the second, when measured
  double movement_sigma_m = 0.001;
  bool depth_correction = true;
  // What the covariance of a ball's centre leaves out: rounding to millimetres, the outline, the lens model.
  double covariance_floor_m = 0.0003;
  // And what it leaves out, too, where depth offsets are not estimated.
  double uncorrected_depth_sigma_m = 0.014;
};

// What a calibration rests on, for the text a person judges it by.
struct SensorEvidence {
  std::string name;
  std::uint64_t frames = 0;
  std::map<std::string, std::uint64_t> statuses;  // how the search of each frame ended
  std::size_t rests = 0;                          // of the ball, as this sensor saw it
  double nearest_m = 0.0, farthest_m = 0.0;       // of the ball at rest
};

// Where the wand was held, of all recordings one after the other.
struct WandViews {
  std::vector<SensorEvidence> evidence;  // one a sensor
  std::vector<WandPosition> positions;
  std::size_t positions_of_first = 0;  // of the first recording, which OptiTrack's export belongs to
  bool simulated = false;              // of any recording
};

struct WandCalibration {
  Calibration calibration;
  WandViews views;
  std::vector<Eigen::Vector3d> position_in_world_m;  // NaN when nothing of it was used
};

// Sensor poses from recordings of a wand that was held still at many places (see the README). All recordings
// are of one rig. The first three places are the world's origin, its x axis and the side of its y axis,
// unless OptiTrack says where the wand was. InputError says which sensor cannot be placed and why.
WandCalibration calibrate_wand(const std::vector<std::filesystem::path>& sessions,
                               const CalibrateWandOptions& options);

// The first half: finds the wand. The second: places the sensors; errors are at `place`.
WandViews view_wand(const std::vector<std::filesystem::path>& sessions, const CalibrateWandOptions& options);
WandCalibration calibrate_views(WandViews views, const std::string& place,
                                const CalibrateWandOptions& options);

}  // namespace trilat
