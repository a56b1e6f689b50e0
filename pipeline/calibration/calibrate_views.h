// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "datasets/rig/calibration.h"
#include "evaluators/calibration/wand_positions.h"
#include "pipeline/calibration/wand_in_world.h"
#include "pipeline/calibration/wand_views.h"

namespace trilat {

struct CalibrateWandOptions : ViewWandOptions {
  std::optional<WandInWorld> world = std::nullopt;
  std::optional<double> baseline_m = std::nullopt;  // from the first place to the second, when measured
  double movement_sigma_m = 0.001;
  bool depth_correction = true;
  // Axis of the paper's two positions; without: y as printed, z (a horizontal axis) corrected.
  std::optional<TrajectoryAxis> trajectory_axis = std::nullopt;
  // Depth uncertainty beside a ball's covariance where depth offsets are not estimated.
  double uncorrected_depth_sigma_m = 0.014;
};

struct WandCalibration {
  Calibration calibration;
  WandObservations views;
  std::vector<Eigen::Vector3d> position_in_world_m;  // NaN when nothing of it was used
};

// InputError at `place` when the wand's first two places, which make the x axis, lie within 0.3 m of each
// other as the sensors saw them.
void check_first_places(const WandObservations& views, const std::string& place);

// Sensor poses from what a wand showed that was held still at many places (see docs/how-to/calibrate.md). The
// first three places are the world's origin, its x axis and the side of its y axis, unless OptiTrack says
// where the wand was. InputError at `place` says which sensor cannot be placed and why.
WandCalibration calibrate_views(WandObservations views, const std::string& place,
                                const CalibrateWandOptions& options);

}  // namespace trilat
