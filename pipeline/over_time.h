// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "pipeline/take_data.h"

namespace trilat {

struct PathPoint {
  Eigen::Vector3d position_m = Eigen::Vector3d::Constant(kNaN);
  SolveStatus status = SolveStatus::not_solved;
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

// All methods of the plan that need a joint's whole path.
std::vector<MethodPaths> solve_over_time(const Plan& plan, const PlannedTake& planned, const TakeData& data);

}  // namespace trilat
