// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "evaluators/solvers/range_problem.h"

namespace trilat {

// The plane that fits a problem's sensors best. A point and its mirror image in a plane that holds
// every sensor have the same ranges, so no method can tell them apart.
struct SensorPlane {
  Eigen::Vector3d centroid_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();
  double mean_range_m = 0.0;
  // Second eigenvalue of the sensors' scatter <= 1e-12 of the largest: on one line within 1e-6 of
  // their spread. The solutions are a circle around the line.
  bool collinear = false;
  // Smallest eigenvalue <= 1e-14 of the largest: in one plane within 1e-7 of their spread.
  bool exact = false;

  double offset_m(const Eigen::Vector3d& x_m) const { return normal.dot(x_m - centroid_m); }
  Eigen::Vector3d mirrored(const Eigen::Vector3d& x_m) const { return x_m - 2.0 * offset_m(x_m) * normal; }
};

SensorPlane plane_of(const RangeProblem& problem);

}  // namespace trilat
