// SPDX-License-Identifier: MIT
#include "evaluators/solvers/geometric.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "evaluators/solvers/descent.h"
#include "evaluators/solvers/sensor_plane.h"

namespace trilat {
namespace {

constexpr double kFlatRatio = 1e-10;
constexpr double kLineRatio = 1e-6;

RangeProblem only(const RangeProblem& problem, const std::array<int, 3>& sensors) {
  RangeProblem three;
  three.guess_m = problem.guess_m;
  for (const int sensor : sensors) {
    for (int i = 0; i < problem.count; ++i) {
      if (problem.rig_index[i] != sensor || three.count == 3) continue;
      three.sensor_m[three.count] = problem.sensor_m[i];
      three.range_m[three.count] = problem.range_m[i];
      three.rig_index[three.count] = sensor;
      ++three.count;
    }
  }
  return three;
}

// The common points of three spheres: foot + height normal and foot - height normal.
struct SphereIntersection {
  bool on_a_line = false;
  Eigen::Vector3d foot_m;
  Eigen::Vector3d normal;
  double height_squared_m2 = kNaN;
};

// In the frame of the sensors: x from the first to the second, y towards the third.
SphereIntersection intersection_of(const RangeProblem& three) {
  const Eigen::Vector3d to_second = three.sensor_m[1] - three.sensor_m[0];
  const Eigen::Vector3d to_third = three.sensor_m[2] - three.sensor_m[0];
  SphereIntersection result;
  const double d = to_second.norm();
  const double longest = std::max(d, to_third.norm());
  result.on_a_line = !(d > kLineRatio * longest);
  if (result.on_a_line) return result;
  const Eigen::Vector3d ex = to_second / d;
  const double i = ex.dot(to_third);
  const Eigen::Vector3d across = to_third - i * ex;
  const double j = across.norm();
  result.on_a_line = !(j > kLineRatio * longest);
  if (result.on_a_line) return result;
  const Eigen::Vector3d ey = across / j;
  const double square = three.range_m[0] * three.range_m[0];
  const double x = (square - three.range_m[1] * three.range_m[1] + d * d) / (2.0 * d);
  const double y = (square - three.range_m[2] * three.range_m[2] + i * i + j * j - 2.0 * i * x) / (2.0 * j);
  result.foot_m = three.sensor_m[0] + x * ex + y * ey;
  result.normal = ex.cross(ey);
  result.height_squared_m2 = square - x * x - y * y;
  return result;
}

}  // namespace

PointEstimate solve_geometric(const RangeProblem& problem, const GeometricOptions& options) {
  const SolveStatus refusal = validate(problem);
  if (refusal != SolveStatus::not_solved) return failed_estimate(refusal);
  const RangeProblem three = only(problem, options.sensors);
  if (three.count < 3) return failed_estimate(SolveStatus::too_few_ranges);
  const SphereIntersection meeting = intersection_of(three);
  if (meeting.on_a_line) return failed_estimate(SolveStatus::rank_deficient);
  if (!std::isfinite(meeting.height_squared_m2) || !meeting.foot_m.allFinite())
    return failed_estimate(SolveStatus::diverged);
  const double longest_m = *std::max_element(three.range_m.begin(), three.range_m.begin() + 3);
  const double flat_m2 = kFlatRatio * longest_m * longest_m;
  if (meeting.height_squared_m2 < -flat_m2)
    return estimate_at(three, meeting.foot_m, SolveStatus::clamped, 0);
  if (meeting.height_squared_m2 <= flat_m2) return failed_estimate(SolveStatus::rank_deficient);
  const Eigen::Vector3d up_m = std::sqrt(meeting.height_squared_m2) * meeting.normal;
  const Eigen::Vector3d above_m = meeting.foot_m + up_m;
  const Eigen::Vector3d below_m = meeting.foot_m - up_m;
  const MirrorChoice choice = choose_mirror(above_m, below_m, three.guess_m);
  return estimate_at(three, choice.first ? above_m : below_m,
                     choice.decided ? SolveStatus::closed_form : SolveStatus::mirror_ambiguous, 0);
}

}  // namespace trilat
