// SPDX-License-Identifier: MIT
#include "pipeline/simulate/watched_depth.h"

#include <algorithm>

#include "datasets/base/error.h"
#include "pipeline/study/parallel.h"

namespace trilat {

SyntheticDepthSource watched_depth_source(const SimulationSpec& spec, const SimulatedItem& item,
                                          const Motion& motion, const std::vector<SimulatedSensor>& sensors,
                                          double duration_s, SceneMotion scene, const Watch& watch,
                                          std::optional<SyntheticTracker> tracker) {
  const double expected =
      std::max(1.0, duration_s * spec.sensor.rate_hz * static_cast<double>(sensors.size()));
  const ForEach for_each = [watch, expected, done = 0.0](
                               std::size_t count, const std::function<void(std::size_t)>& body) mutable {
    parallel_for_index(count, 1, [&](std::size_t i) {
      watch.check();
      body(i);
    });
    done += static_cast<double>(count);
    watch.tell(std::min(1.0, done / expected));
  };
  return {spec.sensor,       item,       motion,
          sensors,           duration_s, {std::move(scene), spec.depth.noise, for_each},
          std::move(tracker)};
}

}  // namespace trilat
