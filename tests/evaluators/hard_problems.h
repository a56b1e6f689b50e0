// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "datasets/base/philox.h"
#include "evaluators/solvers/range_problem.h"
#include "evaluators/solvers/sensor_plane.h"

namespace trilat {

// Random numbers of one problem, one after the other.
struct Draws {
  RandomStream random;
  std::uint32_t next = 0;

  double uniform(double low, double high) { return random.uniform(next++, low, high); }
  double log_uniform(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }
  double normal() { return random.normal(next++); }
  bool chance(double probability) { return uniform(0.0, 1.0) < probability; }
  Eigen::Vector3d direction() { return Eigen::Vector3d(normal(), normal(), normal()).normalized(); }
};

// 3 to 8 sensors, on a ring with jitter or anywhere in the room, at heights that are equal, nearly so (1 mm
// to 5 cm apart) or spread over two metres.
inline void place_sensors(RangeProblem& problem, Draws& draws) {
  problem.count = 3 + static_cast<int>(draws.uniform(0.0, 6.0));
  const double heights = draws.uniform(0.0, 1.0);
  const double middle_m = draws.uniform(0.5, 2.0);
  const double half_m = heights < 0.25 ? 0.0 : draws.log_uniform(0.001, 0.05);
  const bool ring = draws.chance(0.5);
  for (int i = 0; i < problem.count; ++i) {
    const double y = heights < 0.6 ? middle_m + half_m * draws.uniform(-1.0, 1.0) : draws.uniform(0.3, 2.3);
    const double angle_rad = 2.0 * std::numbers::pi * (i + draws.uniform(-0.2, 0.2)) / problem.count;
    const double radius_m = draws.uniform(1.8, 2.2);
    const double x = draws.uniform(-2.5, 2.5), z = draws.uniform(-2.5, 2.5);
    if (ring)
      problem.sensor_m[i] = {radius_m * std::cos(angle_rad), y, radius_m * std::sin(angle_rad)};
    else
      problem.sensor_m[i] = {x, y, z};
  }
}

// Anywhere in the volume, also in the plane that fits the sensors best, close to it, or 10 cm from a sensor.
inline Eigen::Vector3d hard_joint_m(const RangeProblem& problem, Draws& draws) {
  const Eigen::Vector3d joint_m(draws.uniform(-2.5, 2.5), draws.uniform(0.0, 2.5), draws.uniform(-2.5, 2.5));
  const double where = draws.uniform(0.0, 1.0);
  const SensorPlane plane = plane_of(problem);
  const double off_m = draws.log_uniform(1e-6, 0.1);
  if (where < 0.1) return joint_m - plane.offset_m(joint_m) * plane.normal();
  if (where < 0.25) return joint_m + (off_m - plane.offset_m(joint_m)) * plane.normal();
  if (where < 0.4)
    return problem.sensor_m[static_cast<std::size_t>(draws.uniform(0.0, problem.count))] +
           0.1 * draws.direction();
  return joint_m;
}

// The i-th hard problem: ranges wrong by up to 30 cm, one in ten exact; one in five with a guess.
inline RangeProblem hard_problem(std::uint64_t seed, std::uint64_t i) {
  Draws draws{{seed, Purpose::test, i}};
  RangeProblem problem;
  place_sensors(problem, draws);
  const Eigen::Vector3d joint_m = hard_joint_m(problem, draws);
  const double kind = draws.uniform(0.0, 1.0);
  const double most_m = kind < 0.1 ? 0.0 : kind < 0.5 ? draws.log_uniform(1e-4, 0.3) : 0.3;
  for (int k = 0; k < problem.count; ++k)
    problem.range_m[k] =
        std::max(0.0, (joint_m - problem.sensor_m[k]).norm() + most_m * draws.uniform(-1.0, 1.0));
  if (draws.chance(0.2)) problem.guess_m = joint_m + 0.1 * draws.direction();
  return problem;
}

}  // namespace trilat
