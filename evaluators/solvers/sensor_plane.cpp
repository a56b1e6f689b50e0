// SPDX-License-Identifier: MIT
#include "evaluators/solvers/sensor_plane.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace trilat {
namespace {

constexpr double kCollinearRatio = 1e-12;
constexpr double kCoplanarRatio = 1e-12;

// Measured by the offsets and not by the least eigenvalue, whose rounding hides whatever is within 1e-8 of
// the spread: enough to tell the two sides apart.
bool in_one_plane(const RangeProblem& problem, const SensorPlane& plane) {
  if (problem.count == 3) return true;
  double farthest_m = 0.0;
  for (int i = 0; i < problem.count; ++i)
    farthest_m = std::max(farthest_m, std::abs(plane.offset_m(problem.sensor_m[i])));
  return farthest_m <= kCoplanarRatio * std::sqrt(plane.scatter_m2[2]);
}

}  // namespace

SensorPlane plane_of(const RangeProblem& problem) {
  SensorPlane plane;
  for (int i = 0; i < problem.count; ++i) plane.centroid_m += problem.sensor_m[i] / problem.count;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (int i = 0; i < problem.count; ++i) {
    const Eigen::Vector3d s = problem.sensor_m[i] - plane.centroid_m;
    scatter += s * s.transpose();
  }
  plane.collinear = true;
  if (!scatter.allFinite()) return plane;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter);
  plane.axes = eigen.eigenvectors();
  plane.scatter_m2 = eigen.eigenvalues().cwiseMax(0.0);
  plane.collinear = !(plane.scatter_m2[1] > kCollinearRatio * plane.scatter_m2[2]);
  plane.exact = in_one_plane(problem, plane);
  return plane;
}

bool same_sensors(const RangeProblem& a, const RangeProblem& b) {
  return a.count == b.count &&
         std::equal(a.sensor_m.begin(), a.sensor_m.begin() + a.count, b.sensor_m.begin());
}

}  // namespace trilat
