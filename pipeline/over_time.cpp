// SPDX-License-Identifier: MIT
#include "pipeline/over_time.h"

#include "evaluators/fusion/kalman.h"
#include "pipeline/parallel.h"

namespace trilat {
namespace {

// One joint during the whole take as the method's sensors see it: instants x sensors.
std::vector<JointObservation> path_of(const PlannedTake& planned, const TakeData& data, const Method& method,
                                      Joint joint) {
  const std::size_t sensors = planned.world_from_sensor.size();
  std::vector<JointObservation> path(data.time.size() * sensors);
  for (std::size_t i = 0; i < data.time.size(); ++i) {
    const auto instant = std::span(path).subspan(i * sensors, sensors);
    observe_joint(data, i, joint, planned.world_from_sensor, instant);
    const SensorMask used =
        sensors_of(method, {instant, planned.world_from_sensor, occlusions_of(data, i, joint), {}});
    for (std::size_t s = 0; s < sensors; ++s)
      if (!used[s]) instant[s] = {};
  }
  return path;
}

}  // namespace

std::vector<MethodPaths> solve_over_time(const Plan& plan, const PlannedTake& planned, const TakeData& data) {
  std::vector<std::int64_t> time_ns;
  for (const HostTime t : data.time) time_ns.push_back(t.ns);
  std::vector<MethodPaths> all;
  for (std::size_t m = 0; m < plan.methods.size(); ++m)
    if (is_over_time(plan.methods[m]))
      all.push_back({m, plan.joints.size(), std::vector<PathPoint>(time_ns.size() * plan.joints.size())});
  parallel_for_index(all.size() * plan.joints.size(), 1, [&](std::size_t k) {
    MethodPaths& paths = all[k / plan.joints.size()];
    const std::size_t j = k % plan.joints.size();
    const Method& method = plan.methods[paths.method];
    std::vector<PointEstimate> estimates(time_ns.size());
    solve_kalman(time_ns, path_of(planned, data, method, plan.joints[j]), plan.rig.size(), method.spec.kalman,
                 estimates);
    for (std::size_t i = 0; i < estimates.size(); ++i)
      paths.points[i * paths.joints + j] = {estimates[i].position_m, estimates[i].status};
  });
  return all;
}

}  // namespace trilat
