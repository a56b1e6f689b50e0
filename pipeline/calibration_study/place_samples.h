// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "datasets/base/time.h"
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

}  // namespace trilat
