// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/methods/over_time.h"

#include <algorithm>
#include <array>
#include <utility>

#include "datasets/base/error.h"
#include "evaluators/fusion/bone_smoother.h"
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

TrajectoryPoint point_of(const PointEstimate& estimate) {
  return {estimate.position_m, estimate.status, estimate.iterations};
}

}  // namespace

void solve_joints(const Method& method, const TrajectoryInput& seen, const OverTimeCalls&,
                  MethodTrajectories& paths) {
  parallel_for_index(seen.joints.size(), 1, [&](std::size_t j) {
    const JointPath path{seen.time_ns, seen.sensors,
                         [&](std::size_t instant, std::span<JointObservation> observations) {
                           seen.observe(instant, seen.joints[j], observations);
                         }};
    const std::vector<PointEstimate> estimates = solve_kalman(path, method.spec.kalman);
    for (std::size_t i = 0; i < estimates.size(); ++i)
      paths.points[i * paths.joints + j] = point_of(estimates[i]);
  });
}

void solve_bones(const Method& method, const TrajectoryInput& seen, const OverTimeCalls& calls,
                 MethodTrajectories& paths) {
  const std::vector<Joint> joints = joints_with_bones(seen.joints);
  // How many passes it takes is not known before; an hour of simulated walking takes 134.
  constexpr double kHalfwayPasses = 60.0;
  const auto instants = static_cast<double>(seen.time_ns.size());
  double observed = 0.0;
  std::size_t reported = 0;
  const auto report = [&] {
    if (calls.must_stop && calls.must_stop()) throw Interrupted();
    const double passes = observed / (instants * static_cast<double>(joints.size()));
    const auto done = static_cast<std::size_t>(instants * passes / (passes + kHalfwayPasses));
    if (done > reported && calls.advanced) calls.advanced(done - std::exchange(reported, done));
  };
  const BodyPath path{seen.time_ns, joints, seen.sensors,
                      [&](std::size_t instant, std::size_t joint, std::span<JointObservation> observations) {
                        if (instant % 1024 == 0) report();
                        observed += 1.0;
                        seen.observe(instant, joints[joint], observations);
                      }};
  const SmoothedBody body = smooth_bones(path, method.spec.bones);
  for (std::size_t i = 0; i < seen.time_ns.size(); ++i)
    for (std::size_t j = 0; j < paths.joints; ++j) {  // those asked for come first
      const std::size_t slot = i * joints.size() + j;
      const bool is_answered = body.status[slot] != SolveStatus::no_observation;
      paths.points[i * paths.joints + j] = {body.position_m[slot], body.status[slot],
                                            is_answered ? body.passes : 0};
    }
  if (calls.advanced) calls.advanced(seen.time_ns.size() - reported);
}

}  // namespace trilat
