// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <map>
#include <string>
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

}  // namespace trilat
