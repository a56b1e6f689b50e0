// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "datasets/base/strict_json.h"
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

// What one sensor's depth frames show of the wand, all of them or some neighbours.
struct SensorSearch {
  std::vector<TimedSighting> found;               // in the order of time
  std::map<std::string, std::uint64_t> statuses;  // of all frames, by name; sums to frames
  std::uint64_t frames = 0;
};

// Adds what the frames that follow show. Found is only what rises in time.
void append(SensorSearch& search, const SensorSearch& next);

// Neighbouring depth frames of one sensor.
struct FrameRun {
  std::size_t sensor = 0;
  std::uint64_t first = 0, count = 0;
};

// Frames are searched in blocks of so many, each for itself.
inline constexpr std::uint64_t kWandBlock = 60;

// All frames of all sensors in runs of `length`, a multiple of kWandBlock; the last of a sensor may be
// shorter. Sensors one after the other, their runs in the order of the frames.
std::vector<FrameRun> runs_of(std::span<const std::uint64_t> frames_of_sensor, std::uint64_t length);

// Searches runs of a session's depth frames. What runs show, appended in their order, does not depend on
// their length.
class WandSearcher {
 public:
  // `intrinsics`: one entry a sensor. The session must live as long.
  WandSearcher(const SessionReader& session, std::vector<DepthIntrinsics> intrinsics,
               const WandSearchOptions& options);
  ~WandSearcher();
  WandSearcher(const WandSearcher&) = delete;
  WandSearcher& operator=(const WandSearcher&) = delete;

  // On the threads of the current arena, from any of them, with a few frames in memory. Interrupted when
  // asked to stop.
  SensorSearch search(const FrameRun& run, const Watch& watch);

 private:
  struct Sensor;
  Sensor& sensor(std::size_t index);
  SensorSearch search_block(const FrameRun& block, const Watch& watch);

  const SessionReader& session_;
  std::vector<DepthIntrinsics> intrinsics_;
  WandSearchOptions options_;
  std::vector<std::unique_ptr<Sensor>> sensors_;
};

// All depth frames of a session, one entry a sensor. The result does not depend on the number of threads.
std::vector<SensorSearch> search_wand(const SessionReader& session,
                                      const std::vector<DepthIntrinsics>& intrinsics,
                                      const WandSearchOptions& options);

// What items of a wand search came to, as documents that read back to the last bit. InputError at `place`
// when one is not as it was written.
Json json_of(const SensorSearch& search);
SensorSearch read_sensor_search(const Json& json, const std::string& place);

Json json_of(const WandTrack& track);
WandTrack wand_track_of(const Json& json, const std::string& place);

}  // namespace trilat
