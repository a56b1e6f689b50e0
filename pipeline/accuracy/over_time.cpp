// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/over_time.h"

#include <algorithm>
#include <array>

#include "datasets/base/error.h"
#include "evaluators/ceres/bone_window.h"
#include "evaluators/fusion/kalman.h"
#include "pipeline/accuracy/method_kinds.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

// One joint at one instant as the method's sensors see it.
void observe_for(const Method& method, const PlannedTake& planned, const TakeData& data, std::size_t instant,
                 Joint joint, std::span<JointObservation> observations) {
  observe_joint(data, instant, joint, planned.world_from_sensor, observations);
  const SensorMask used =
      sensors_of(method, {observations, planned.world_from_sensor, occlusions_of(data, instant, joint), {}});
  for (std::size_t s = 0; s < observations.size(); ++s)
    if (!used[s]) observations[s] = {};
}

// The joints of the plan, and those that bones join to them. Hands and feet follow their neighbours least and
// are off most: they are left out unless the plan has them.
std::vector<Joint> joints_with_bones(const std::vector<Joint>& plan_joints) {
  constexpr std::array kEnds{Joint::hand_left,      Joint::hand_right, Joint::hand_tip_left,
                             Joint::hand_tip_right, Joint::thumb_left, Joint::thumb_right,
                             Joint::foot_left,      Joint::foot_right};
  std::vector<Joint> joints = plan_joints;
  for (const Joint joint : kJointsRootFirst)
    if (std::ranges::find(kEnds, joint) == kEnds.end() && std::ranges::find(joints, joint) == joints.end())
      joints.push_back(joint);
  return joints;
}

}  // namespace

void solve_joints(const TakeInTime& take, MethodPaths& paths) {
  const auto& [plan, planned, data, time_ns, calls] = take;
  const Method& method = plan.methods[paths.method];
  const std::size_t sensors = planned.world_from_sensor.size();
  parallel_for_index(plan.joints.size(), 1, [&](std::size_t j) {
    std::vector<JointObservation> path(time_ns.size() * sensors);
    for (std::size_t i = 0; i < time_ns.size(); ++i)
      observe_for(method, planned, data, i, plan.joints[j], std::span(path).subspan(i * sensors, sensors));
    std::vector<PointEstimate> estimates(time_ns.size());
    solve_kalman(time_ns, path, sensors, method.spec.kalman, estimates);
    for (std::size_t i = 0; i < estimates.size(); ++i)
      paths.points[i * paths.joints + j] = {estimates[i].position_m, estimates[i].status,
                                            estimates[i].iterations};
  });
}

void solve_windows(const TakeInTime& take, MethodPaths& paths) {
  const auto& [plan, planned, data, time_ns, calls] = take;
  const Method& method = plan.methods[paths.method];
  const BoneWindowOptions& options = method.spec.window;
  const std::vector<Joint> joints = joints_with_bones(plan.joints);
  const std::size_t sensors = planned.world_from_sensor.size();
  std::vector<JointObservation> seen(time_ns.size() * joints.size() * sensors);
  parallel_for_index(time_ns.size(), 64, [&](std::size_t i) {
    for (std::size_t j = 0; j < joints.size(); ++j)
      observe_for(method, planned, data, i, joints[j],
                  std::span(seen).subspan((i * joints.size() + j) * sensors, sensors));
  });
  const BodyPath path{time_ns, joints, sensors, seen};
  const BoneWindows windows = plan_bone_windows(path, options);
  std::vector<PointEstimate> estimates(time_ns.size() * joints.size());
  parallel_for_index(windows.windows.size(), 1, [&](std::size_t k) {
    if (calls.must_stop && calls.must_stop()) throw Interrupted();
    solve_bone_window(path, windows, k, options, estimates);
    if (calls.advanced) calls.advanced(windows.windows[k].answer_last - windows.windows[k].answer_first);
  });
  for (std::size_t i = 0; i < time_ns.size(); ++i)
    for (std::size_t j = 0; j < paths.joints; ++j) {
      const PointEstimate& estimate = estimates[i * joints.size() + j];  // those of the plan come first
      paths.points[i * paths.joints + j] = {estimate.position_m, estimate.status, estimate.iterations};
    }
}

std::size_t windowed_methods(const Plan& plan) {
  return static_cast<std::size_t>(std::ranges::count_if(
      plan.methods, [](const Method& method) { return method.spec.kind->over_time == solve_windows; }));
}

std::vector<MethodPaths> solve_over_time(const Plan& plan, const PlannedTake& planned, const TakeData& data,
                                         const OverTimeCalls& calls) {
  TakeInTime take{plan, planned, data, {}, calls};
  for (const HostTime t : data.time) take.time_ns.push_back(t.ns);
  std::vector<MethodPaths> all;
  for (std::size_t m = 0; m < plan.methods.size(); ++m)
    if (is_over_time(plan.methods[m]))
      all.push_back(
          {m, plan.joints.size(), std::vector<PathPoint>(take.time_ns.size() * plan.joints.size())});
  parallel_for_index(all.size(), 1,
                     [&](std::size_t k) { plan.methods[all[k].method].spec.kind->over_time(take, all[k]); });
  return all;
}

}  // namespace trilat
