// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "datasets/base/time.h"
#include "datasets/rig/calibration.h"
#include "datasets/rig/campaign.h"
#include "datasets/session/session_reader.h"
#include "evaluators/wand/wand_sighting.h"
#include "pipeline/calibration_study/calibration_summary.h"
#include "pipeline/study/run_control.h"

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

// Result of every method at one place.
struct PlaceOutcome {
  std::vector<Eigen::Vector3d> centre_in_sensor_m;  // by method; NaN without an answer
  std::vector<WandStatus> status;
};

// Looks for the ball at each place in at most `recording.frames` frames, whose mean counts, and adds a sample
// a method to `recording`, with its sensors; gives what was found, in the order of the places.
std::vector<PlaceOutcome> measure_places(const SessionReader& session, const std::vector<WandPlace>& places,
                                         WandRecording& recording, const RunControl& control);

// Angle between a direction and the lens' axis.
double angle_of(const Eigen::Vector3d& point_in_sensor_m);

// Reads places.csv: from_s, to_s (since the first depth frame), sensor, distance_m, and angle_deg where it is
// known. InputError with the line where a distance is none in metres, a sensor or a time is not in the
// session.
std::vector<WandPlace> read_stated_places(const std::filesystem::path& csv, const SessionReader& session);

// Errors of every way to find the ball, each the mean of at most `frames` frames of a place. InputError at
// the places' file where the stated distances are not those of what the sensors see.
WandRecording measure_stated_distances(const StatedDistances& stated, std::uint64_t frames,
                                       const RunControl& control);

// Measures a wand's recording. A tenth of the places after the third is left out in turn: in the poses
// that the others give, the truth is where OptiTrack saw the ball there, or, without an export, where the
// other sensors did. Poses by each way to calibrate are held against `stated`, where both are in
// OptiTrack's world. InputError says what a calibration is lacking.
WandRecording measure_wand(const CampaignWand& wand, const std::optional<Calibration>& stated,
                           std::uint64_t frames, const RunControl& control);

// Measures each sensor's depth of a flat wall, against a plane that is fitted to the mean of its frames.
// InputError where less than four fifths of what a sensor sees lies within 3 cm of one plane.
WallRecording measure_wall(const FlatWall& wall, const RunControl& control);

}  // namespace trilat
