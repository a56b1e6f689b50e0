// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/base/philox.h"
#include "evaluators/solvers/range_problem.h"

namespace trilat {

inline RangeProblem problem_of(const std::vector<Eigen::Vector3d>& sensors_m,
                               const Eigen::Vector3d& joint_m) {
  RangeProblem problem;
  problem.count = static_cast<int>(sensors_m.size());
  for (int i = 0; i < problem.count; ++i) {
    problem.sensor_m[i] = sensors_m[i];
    problem.range_m[i] = (joint_m - sensors_m[i]).norm();
  }
  return problem;
}

// Four sensors around a joint, 2 m from the middle, at the heights given.
inline std::vector<Eigen::Vector3d> ring_m(double h0_m, double h1_m, double h2_m, double h3_m) {
  return {{2, h0_m, 0}, {0, h1_m, 2}, {-2, h2_m, 0}, {0, h3_m, -2}};
}

inline std::vector<Eigen::Vector3d> well_posed_sensors_m() { return ring_m(0.3, 2.3, 0.3, 2.3); }

// A joint of a person in the middle of the ring.
inline Eigen::Vector3d random_joint_m(const RandomStream& random, std::uint32_t index) {
  return {random.uniform(3 * index, -0.6, 0.6), random.uniform(3 * index + 1, 0.1, 1.9),
          random.uniform(3 * index + 2, -0.6, 0.6)};
}

inline void add_noise(RangeProblem& problem, const RandomStream& random, double sigma_m) {
  for (int i = 0; i < problem.count; ++i)
    problem.range_m[i] =
        std::max(0.0, problem.range_m[i] + sigma_m * random.normal(static_cast<std::uint32_t>(i)));
}

}  // namespace trilat
