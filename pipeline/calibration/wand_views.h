// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "datasets/rig/depth_camera.h"
#include "datasets/session/session_reader.h"
#include "evaluators/calibration/wand_positions.h"
#include "evaluators/wand/find_wand.h"
#include "pipeline/calibration/wand_in_world.h"
#include "pipeline/study/run_control.h"

namespace trilat {

struct WandSearchOptions {
  FindWandOptions find;
  // Between two searches of the whole image the ball is looked for where it was in the frame before; a second
  // ball is noticed at the next whole search.
  std::uint64_t whole_image_every = 15;
  RunControl control = {};
};

// Evidence that a calibration rests on, for the text a person judges it by.
struct SensorEvidence {
  std::string name;
  std::uint64_t frames = 0;
  std::map<std::string, std::uint64_t> statuses;  // how the search of each frame ended
  std::size_t rests = 0;                          // of the ball, as this sensor saw it
  double nearest_m = 0.0, farthest_m = 0.0;       // of the ball at rest
  // Radius of the ball that the frames show where it is half or twice the stated one; looked for where the
  // sensor saw no rest.
  std::optional<double> other_radius_m = std::nullopt;
  std::optional<std::string> doubt = std::nullopt;  // about the camera's intrinsics
};

// Places of the wand, of all recordings one after the other.
struct WandObservations {
  std::vector<SensorEvidence> evidence;  // one a sensor
  std::vector<WandPosition> positions;
  std::size_t positions_of_first = 0;  // of the first recording, which OptiTrack's export belongs to
  bool simulated = false;              // of any recording
};

struct ViewWandOptions {
  WandSearchOptions search;
  WandPositionOptions positions;
};

// Finds the places of the wand in recordings of one rig, by all their depth frames. The result does not
// depend on the number of threads. InputError names the sensor that has no depth or other images, and the
// recording with other sensors than the first.
WandObservations view_wand(std::span<const SessionReader> sessions, const ViewWandOptions& options);

// When the first depth frame of any sensor was exposed. InputError where there is none.
HostTime start_of_depth(const SessionReader& session);

// One entry a sensor.
std::vector<bool> sensors_that_saw(const WandObservations& views);

// Leaves out places that only one sensor saw, which do not show its pose beside the others, and
// places nearer than 5 cm to the one before: a hand that drifts may make two rests of one place.
void drop_unusable_positions(WandObservations& views);

// How far the sensors saw the ball move from the first place to the second; nothing when none saw both.
std::optional<double> seen_movement_m(const WandObservations& views);

}  // namespace trilat
