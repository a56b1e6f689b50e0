// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "datasets/geometry/depth_camera.h"
#include "datasets/session/session_reader.h"
#include "evaluators/calibration/wand_positions.h"
#include "evaluators/wand/find_wand.h"

namespace trilat {

struct WandSearchOptions {
  FindWandOptions find;
  // Between two searches of the whole image the ball is looked for where it was in the frame before; a second
  // ball is noticed at the next whole search.
  std::uint64_t whole_image_every = 15;
  std::function<bool()> stop_requested = {};
  std::function<void(double)> progress = {};
};

// What one sensor's depth frames show of the wand.
struct SensorSearch {
  std::vector<TimedSighting> found;               // in the order of time
  std::map<std::string, std::uint64_t> statuses;  // of all frames, by name; sums to frames
  std::uint64_t frames = 0;
};

// Searches every depth frame of a session, on the threads of the current arena and with a few frames in
// memory. `intrinsics` holds one entry a sensor. The result does not depend on the number of threads.
// Interrupted when asked to stop.
std::vector<SensorSearch> search_wand(const SessionReader& session,
                                      const std::vector<DepthIntrinsics>& intrinsics,
                                      const WandSearchOptions& options);

}  // namespace trilat
