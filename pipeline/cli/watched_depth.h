// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <vector>

#include "recorders/synthetic_depth_source.h"

namespace trilat {

// How somebody watches and ends long work.
struct SimulationWatch {
  std::function<bool()> stop_requested = {};
  std::function<void(double share)> progress = {};
};

// A source with depth that renders on all processors, tells how far it is and ends by Interrupted.
SyntheticDepthSource watched_depth_source(const SimulationSpec& spec, const SimulatedItem& item,
                                          const Motion& motion, const std::vector<SimulatedSensor>& sensors,
                                          double duration_s, SceneMotion scene, const SimulationWatch& watch,
                                          std::optional<SyntheticTracker> tracker = {});

}  // namespace trilat
