// SPDX-License-Identifier: MIT
#include "evaluators/solvers/sensor_plane.h"

#include <algorithm>

#include <Eigen/Eigenvalues>

namespace trilat {
namespace {

constexpr double kCollinearRatio = 1e-12;
constexpr double kCoplanarRatio = 1e-14;

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
  plane.exact = !(plane.scatter_m2[0] > kCoplanarRatio * plane.scatter_m2[2]);
  return plane;
}

bool same_sensors(const RangeProblem& a, const RangeProblem& b) {
  return a.count == b.count &&
         std::equal(a.sensor_m.begin(), a.sensor_m.begin() + a.count, b.sensor_m.begin());
}

}  // namespace trilat
