// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "pipeline/accuracy/methods/method.h"

namespace trilat {

struct TrajectoryPoint {
  Eigen::Vector3d position_m = Eigen::Vector3d::Constant(kNaN);
  SolveStatus status = SolveStatus::not_solved;
  int iterations = 0;
};

// The answers of one method over time for one take, by instant and joint.
struct MethodTrajectories {
  std::size_t method = 0;
  std::size_t joints = 0;
  std::vector<TrajectoryPoint> points;
  const TrajectoryPoint& at(std::size_t instant, std::size_t joint) const {
    return points[instant * joints + joint];
  }
};

// Both are called from any thread. `advanced` counts how many instants more of one windowed method are done.
struct OverTimeCalls {
  std::function<void(std::size_t)> advanced;
  std::function<bool()> must_stop;
};

// A take as a method over time sees it.
struct TrajectoryInput {
  std::span<const std::int64_t> time_ns;  // of the instants
  std::size_t sensors = 0;
  std::span<const Joint> joints;  // that are asked for
  // One joint at one instant, as the method's sensors see it; from any thread.
  std::function<void(std::size_t instant, Joint joint, std::span<JointObservation> observations)> observe;
};

using OverTimeSolver = void (*)(const Method& method, const TrajectoryInput& seen, const OverTimeCalls& calls,
                                MethodTrajectories& paths);
// Each joint by itself.
void solve_joints(const Method& method, const TrajectoryInput& seen, const OverTimeCalls& calls,
                  MethodTrajectories& paths);
// All joints together, which takes long. Throws Interrupted when asked to stop.
void solve_bones(const Method& method, const TrajectoryInput& seen, const OverTimeCalls& calls,
                 MethodTrajectories& paths);

}  // namespace trilat
