// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>

#include "evaluators/solvers/point_estimate.h"

namespace trilat {

inline constexpr int kMaxSensors = 8;

// One joint at one instant: how far it is from each of `count` sensors that see it. Entries from `count` on
// are not read. Fixed capacity: making and solving one allocates nothing.
struct RangeProblem {
  int count = 0;
  std::array<Eigen::Vector3d, kMaxSensors> sensor_m;  // world
  std::array<double, kMaxSensors> range_m;
  // Which sensor of the rig the entry comes from. Settings that name a sensor mean this number, so that they
  // keep their meaning when another sensor does not see the joint.
  std::array<int, kMaxSensors> rig_index{0, 1, 2, 3, 4, 5, 6, 7};
  // Roughly where the joint is in the world, such as the mean of the sensors' own positions. It only decides
  // between mirror solutions and may serve as a start; nothing is pulled towards it.
  std::optional<Eigen::Vector3d> guess_m;
};

// not_solved when the problem may be solved, else why not: too_few_ranges, non_finite_input or invalid_input.
// InternalError when `count` is beyond the capacity.
[[nodiscard]] SolveStatus validate(const RangeProblem& problem);

}  // namespace trilat
