// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <vector>

#include "pipeline/accuracy/take_data.h"

namespace trilat {

struct PathPoint {
  Eigen::Vector3d position_m = Eigen::Vector3d::Constant(kNaN);
  SolveStatus status = SolveStatus::not_solved;
  int iterations = 0;
};

// What one method over time gives for one take: by instant and joint of the plan.
struct MethodPaths {
  std::size_t method = 0;
  std::size_t joints = 0;
  std::vector<PathPoint> points;
  const PathPoint& at(std::size_t instant, std::size_t joint) const {
    return points[instant * joints + joint];
  }
};

// Both are called from any thread. `advanced` tells how many instants more of one windowed method are done.
struct OverTimeCalls {
  std::function<void(std::size_t)> advanced;
  std::function<bool()> must_stop;
};

// A take as methods over time see it.
struct TakeInTime {
  const Plan& plan;
  const PlannedTake& planned;
  const TakeData& data;
  std::vector<std::int64_t> time_ns;  // of the instants
  const OverTimeCalls& calls;
};
using OverTimeSolver = void (*)(const TakeInTime& take, MethodPaths& paths);
// Each joint of the plan by itself.
void solve_joints(const TakeInTime& take, MethodPaths& paths);
// All joints together, window by window.
void solve_windows(const TakeInTime& take, MethodPaths& paths);

// How many methods of the plan solve windows of all joints together, which takes long.
std::size_t windowed_methods(const Plan& plan);

// All methods of the plan that need whole paths. Throws Interrupted when asked to stop.
std::vector<MethodPaths> solve_over_time(const Plan& plan, const PlannedTake& planned, const TakeData& data,
                                         const OverTimeCalls& calls);

}  // namespace trilat
