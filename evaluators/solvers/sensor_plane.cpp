// SPDX-License-Identifier: MIT
#include "evaluators/solvers/sensor_plane.h"

#include "evaluators/solvers/symmetric3.h"

namespace trilat {
namespace {

constexpr double kCollinearRatio = 1e-12;
constexpr double kCoplanarRatio = 1e-14;

}  // namespace

SensorPlane plane_of(const RangeProblem& problem) {
  SensorPlane plane;
  for (int i = 0; i < problem.count; ++i) {
    plane.centroid_m += problem.sensor_m[i] / problem.count;
    plane.mean_range_m += problem.range_m[i] / problem.count;
  }
  Symmetric3 scatter;
  for (int i = 0; i < problem.count; ++i) scatter.add_outer(1.0, problem.sensor_m[i] - plane.centroid_m);
  const Symmetric3 adjugate = scatter.adjugate();
  const double trace = scatter.trace();
  const double pairs = adjugate.trace();
  plane.collinear = !(pairs > kCollinearRatio * trace * trace);
  if (plane.collinear) return plane;
  plane.exact = !(scatter.determinant(adjugate) > kCoplanarRatio * trace * pairs);
  // The adjugate's largest eigenvalue belongs to the normal, and stands out by the ratio of the two
  // smaller eigenvalues of the scatter: two powers settle the direction of any plane that matters.
  Eigen::Vector3d normal{adjugate.xx, adjugate.xy, adjugate.xz};
  if (adjugate.yy > adjugate.xx && adjugate.yy >= adjugate.zz)
    normal = {adjugate.xy, adjugate.yy, adjugate.yz};
  else if (adjugate.zz > adjugate.xx)
    normal = {adjugate.xz, adjugate.yz, adjugate.zz};
  plane.normal = (adjugate * normal.normalized()).normalized();
  return plane;
}

}  // namespace trilat
