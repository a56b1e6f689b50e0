// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "pipeline/study/watch.h"
#include "recorders/synthetic_depth_source.h"

namespace trilat {

// A source with depth that renders on all processors, tells how far it is and ends by Interrupted.
SyntheticDepthSource watched_depth_source(const SimulationSpec& spec, const SimulatedItem& item,
                                          const Motion& motion, const std::vector<SimulatedSensor>& sensors,
                                          double duration_s, SceneMotion scene, const Watch& watch,
                                          std::optional<SyntheticTracker> tracker = {});

}  // namespace trilat
