// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/methods/over_time.h"

#include <algorithm>
#include <array>

#include "datasets/base/error.h"
#include "evaluators/fusion/bone_window.h"
#include "evaluators/fusion/kalman.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

// The joints that are asked for, and those that bones join to them. Hands and feet follow their neighbours
// least and are off most: they are left out unless they are asked for.
std::vector<Joint> joints_with_bones(std::span<const Joint> asked) {
  constexpr std::array kEnds{Joint::hand_left,      Joint::hand_right, Joint::hand_tip_left,
                             Joint::hand_tip_right, Joint::thumb_left, Joint::thumb_right,
                             Joint::foot_left,      Joint::foot_right};
  std::vector<Joint> joints(asked.begin(), asked.end());
  for (const Joint joint : kJointsRootFirst)
    if (std::ranges::find(kEnds, joint) == kEnds.end() && std::ranges::find(joints, joint) == joints.end())
      joints.push_back(joint);
  return joints;
}

}  // namespace

void solve_joints(const Method& method, const SeenInTime& seen, const OverTimeCalls&, MethodPaths& paths) {
  const std::size_t instants = seen.time_ns.size(), sensors = seen.sensors;
  parallel_for_index(seen.joints.size(), 1, [&](std::size_t j) {
    std::vector<JointObservation> path(instants * sensors);
    for (std::size_t i = 0; i < instants; ++i)
      seen.observe(i, seen.joints[j], std::span(path).subspan(i * sensors, sensors));
    std::vector<PointEstimate> estimates(instants);
    solve_kalman(seen.time_ns, path, sensors, method.spec.kalman, estimates);
    for (std::size_t i = 0; i < instants; ++i)
      paths.points[i * paths.joints + j] = {estimates[i].position_m, estimates[i].status,
                                            estimates[i].iterations};
  });
}

void solve_windows(const Method& method, const SeenInTime& seen, const OverTimeCalls& calls,
                   MethodPaths& paths) {
  const BoneWindowOptions& options = method.spec.window;
  const std::vector<Joint> joints = joints_with_bones(seen.joints);
  const std::size_t instants = seen.time_ns.size(), sensors = seen.sensors;
  std::vector<JointObservation> observations(instants * joints.size() * sensors);
  parallel_for_index(instants, 64, [&](std::size_t i) {
    for (std::size_t j = 0; j < joints.size(); ++j)
      seen.observe(i, joints[j], std::span(observations).subspan((i * joints.size() + j) * sensors, sensors));
  });
  const BodyPath path{seen.time_ns, joints, sensors, observations};
  const BoneWindows windows = plan_bone_windows(path, options);
  std::vector<PointEstimate> estimates(instants * joints.size());
  parallel_for_index(windows.windows.size(), 1, [&](std::size_t k) {
    if (calls.must_stop && calls.must_stop()) throw Interrupted();
    solve_bone_window(path, windows, k, options, estimates);
    if (calls.advanced) calls.advanced(windows.windows[k].answer_last - windows.windows[k].answer_first);
  });
  for (std::size_t i = 0; i < instants; ++i)
    for (std::size_t j = 0; j < paths.joints; ++j) {
      const PointEstimate& estimate = estimates[i * joints.size() + j];  // those asked for come first
      paths.points[i * paths.joints + j] = {estimate.position_m, estimate.status, estimate.iterations};
    }
}

}  // namespace trilat
