// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/calibration/calibration.h"
#include "evaluators/ceres/rig_refinement.h"
#include "pipeline/calibration/wand_views.h"

namespace trilat {

// An OptiTrack export of the wand, which ties the calibration to OptiTrack's world.
struct WandInWorld {
  std::filesystem::path mocap;
  std::string asset;  // whose position is the ball's centre
  std::int64_t mocap_start_host_ns = 0;
  double sigma_m = 0.001;
};

struct CalibrateWandOptions : ViewWandOptions {
  std::optional<WandInWorld> world = std::nullopt;
  std::optional<double> movement_m = std::nullopt;  // from the first place to the second, when measured
  double movement_sigma_m = 0.001;
  bool depth_correction = true;
  // What the covariance of a ball's centre leaves out: rounding to millimetres, the outline, the lens model.
  double covariance_floor_m = 0.0003;
  // And what it leaves out, too, where depth offsets are not estimated.
  double uncorrected_depth_sigma_m = 0.014;
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

// The same of what has been found already; errors are at `place`.
WandCalibration calibrate_views(WandViews views, const std::string& place,
                                const CalibrateWandOptions& options);

}  // namespace trilat
