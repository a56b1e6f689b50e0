// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include "datasets/geometry/rigid_transform.h"
#include "evaluators/calibration/rig_problem.h"

namespace trilat {

struct RigStartOptions {
  double tolerance_m = 0.05;      // a common point farther off than this does not support a motion
  double least_breadth_m = 0.05;  // root mean square spread of the common points across their main direction
  int tries = 300;                // triples of points tried a pair of sensors, the same in every run
};

struct RigStart {
  std::vector<SensorPlacement> placement;             // one a sensor
  std::vector<RigidTransform> reference_from_sensor;  // of the sensors that are placed
  std::size_t reference = 0;                          // the sensor with most observations
  bool complete() const;
};

// Poses to start a refinement from: for every pair of sensors the rigid motion that most of their common
// points support (three points at a time, Fischler and Bolles 1981; then least squares on the supporters,
// Horn 1987), chained from the reference along the best supported pairs. Wrong points may be among them.
[[nodiscard]] RigStart start_rig(const RigProblem& problem, const RigStartOptions& options);

}  // namespace trilat
