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

#include "datasets/geometry/depth_camera.h"
#include "datasets/session/session_reader.h"
#include "evaluators/calibration/wand_positions.h"
#include "evaluators/wand/find_wand.h"
#include "pipeline/calibration/wand_in_world.h"
#include "pipeline/study/watch.h"

namespace trilat {

struct WandSearchOptions {
  FindWandOptions find;
  // Between two searches of the whole image the ball is looked for where it was in the frame before; a second
  // ball is noticed at the next whole search.
  std::uint64_t whole_image_every = 15;
  Watch watch = {};
};

// What one sensor's depth frames show of the wand.
struct SensorSearch {
  std::vector<TimedSighting> found;               // in the order of time
  std::map<std::string, std::uint64_t> statuses;  // of all frames, by name; sums to frames
  std::uint64_t frames = 0;
};

// Adds what the frames that follow show. Found is only what rises in time.
void append(SensorSearch& search, const SensorSearch& next);

// All depth frames of a session, one entry a sensor. The result does not depend on the number of threads.
std::vector<SensorSearch> search_wand(const SessionReader& session,
                                      const std::vector<DepthIntrinsics>& intrinsics,
                                      const WandSearchOptions& options);

struct RecordedSensor {
  std::string name;
  std::uint64_t frames = 0;  // with depth
  DepthIntrinsics intrinsics;
  std::optional<FloorPlane> floor = std::nullopt;
};

// What a calibration needs to know of a recording of the wand besides what its depth frames show.
struct WandRecording {
  std::string place;  // the file, for errors
  bool simulated = false;
  std::vector<RecordedSensor> sensors = {};
};

using NamedIntrinsics = std::vector<std::pair<std::string, std::filesystem::path>>;  // sensor, OpenCV file

// Of recordings of one rig, without hashes. `intrinsics`: instead of the sessions' own; `floors`: whether
// they are looked for. InputError names the sensor that has no depth or other images, the recording with
// other sensors than the first, or the intrinsics file that cannot be this sensor's.
std::vector<WandRecording> read_wand_recordings(std::span<const SessionReader> sessions,
                                                const NamedIntrinsics& intrinsics, bool floors);

bool are_of_one_rig(const WandRecording& a, const WandRecording& b);
std::vector<DepthIntrinsics> intrinsics_of(const WandRecording& recording);

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

struct ViewWandOptions {
  WandSearchOptions search;
  WandPositionOptions positions;
  NamedIntrinsics intrinsics = {};  // instead of the sessions' own
};

// Adds where the wand was held in a recording. `searches`: one a sensor.
void add_recording(WandViews& views, const WandRecording& recording, std::span<const SensorSearch> searches,
                   const WandPositionOptions& options);

// One entry a sensor.
std::vector<bool> sensors_that_saw(const WandViews& views);

// Leaves out places that only one sensor saw, which say nothing of where it stands beside the others, and
// places nearer than 5 cm to the one before: a hand that drifts may make two rests of one place.
void keep_useful_positions(WandViews& views);

// How far the sensors saw the ball move from the first place to the second; nothing when none saw both.
std::optional<double> seen_movement_m(const WandViews& views);

}  // namespace trilat
