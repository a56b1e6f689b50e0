// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "datasets/base/time.h"
#include "datasets/calibration/calibration.h"
#include "datasets/session/session_reader.h"
#include "datasets/take/campaign.h"
#include "pipeline/calibration_study/calibration_summary.h"
#include "pipeline/study/watch.h"

namespace trilat {

// Ways to find the ball in a depth image: the paper's (eq. 1 to 5) as printed, with one error each left in,
// corrected, and ours.
const std::vector<std::string>& wand_method_names();
// The number of one of them.
std::size_t wand_method(const std::string& name);

// A place of the ball as one sensor sees it, and the truth about it.
struct WandPlace {
  HostTime first, last;  // while the ball is held there
  std::size_t sensor = 0, place = 0;
  double distance_m = 0.0;
  std::optional<double> angle_rad = {};  // from the lens' axis
  std::optional<Eigen::Vector3d> ball_in_sensor_m = {};
};

// Reads places.csv: from_s, to_s (since the first depth frame), sensor, distance_m, and angle_deg where it is
// known. InputError with the line where a distance is none in metres, a sensor or a time is not in the
// session.
std::vector<WandPlace> read_stated_places(const std::filesystem::path& csv, const SessionReader& session);

// Errors of every way to find the ball, each the mean of at most `frames` frames of a place. InputError at
// the places' file where the stated distances are not those of what the sensors see.
WandRecording measure_stated_distances(const StatedDistances& stated, std::uint64_t frames,
                                       const Watch& watch);

// The same of a wand's recording. A tenth of the places after the third is left out in turn: in the poses
// that the others give, the truth is where OptiTrack saw the ball there, or, without an export, where the
// other sensors did. Poses by each way to calibrate are held against `stated`, where both are in
// OptiTrack's world. InputError says what a calibration is lacking.
WandRecording measure_wand(const CampaignWand& wand, const std::optional<Calibration>& stated,
                           std::uint64_t frames, const Watch& watch);

}  // namespace trilat
