// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/take_paths.h"

#include <algorithm>

#include "pipeline/accuracy/methods/method_kinds.h"
#include "pipeline/study/parallel.h"

namespace trilat {

std::size_t windowed_methods(const Plan& plan) {
  return static_cast<std::size_t>(std::ranges::count_if(
      plan.methods, [](const Method& method) { return method.spec.kind->over_time == solve_windows; }));
}

std::vector<MethodPaths> solve_over_time(const Plan& plan, const PlannedTake& planned, const TakeData& data,
                                         const OverTimeCalls& calls) {
  std::vector<std::int64_t> time_ns;
  for (const HostTime t : data.time) time_ns.push_back(t.ns);
  std::vector<MethodPaths> all;
  for (std::size_t m = 0; m < plan.methods.size(); ++m)
    if (is_over_time(plan.methods[m]))
      all.push_back({m, plan.joints.size(), std::vector<PathPoint>(time_ns.size() * plan.joints.size())});
  parallel_for_index(all.size(), 1, [&](std::size_t k) {
    const Method& method = plan.methods[all[k].method];
    const auto observe = [&](std::size_t instant, Joint joint, std::span<JointObservation> observations) {
      observe_joint(data, planned, method.spec.calibration_is_estimated, instant, joint, observations);
      const SensorMask used = sensors_of(
          method, {observations, planned.world_from_sensor, occlusions_of(data, instant, joint), {}});
      for (std::size_t s = 0; s < observations.size(); ++s)
        if (!used[s]) observations[s] = {};
    };
    method.spec.kind->over_time(method, {time_ns, planned.world_from_sensor.size(), plan.joints, observe},
                                calls, all[k]);
  });
  return all;
}

}  // namespace trilat
