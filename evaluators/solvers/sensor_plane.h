// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "evaluators/solvers/range_problem.h"

namespace trilat {

// How a problem's sensors stand: their middle, the plane that fits them best, and their scatter along
// and across it. A point and its mirror image in a plane that holds every sensor have the same ranges,
// so no method can tell them apart.
struct SensorPlane {
  Eigen::Vector3d centroid_m = Eigen::Vector3d::Zero();
  // Columns: the eigenvectors of sum (s - centroid)(s - centroid)^T, and its eigenvalues, ascending.
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  Eigen::Vector3d scatter_m2 = Eigen::Vector3d::Zero();
  // Second eigenvalue of the scatter <= 1e-12 of the largest: on one line within 1e-6 of their spread.
  // The solutions are a circle around the line.
  bool collinear = false;
  // Three sensors; or none farther from the plane than 1e-12 of the root of the largest eigenvalue. Then the
  // ranges on both sides agree to rounding.
  bool exact = false;

  Eigen::Vector3d normal() const { return axes.col(0); }
  double offset_m(const Eigen::Vector3d& x_m) const { return normal().dot(x_m - centroid_m); }
  Eigen::Vector3d mirrored(const Eigen::Vector3d& x_m) const { return x_m - 2.0 * offset_m(x_m) * normal(); }
};

SensorPlane plane_of(const RangeProblem& problem);

// Whether both problems have the same sensors in the same order, and so the same plane.
bool same_sensors(const RangeProblem& a, const RangeProblem& b);

}  // namespace trilat
