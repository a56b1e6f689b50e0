// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/rig_gdop.h"

#include <algorithm>
#include <cmath>

#include "evaluators/solvers/precision.h"

namespace trilat {
namespace {

constexpr double kHeight_m = 1.0;
constexpr double kAround_m = 0.5;
constexpr std::size_t kPoints = 41;  // an axis

std::vector<double> axis_over(double from, double to) {
  std::vector<double> values(kPoints);
  for (std::size_t k = 0; k < kPoints; ++k)
    values[k] = from + (to - from) * static_cast<double>(k) / static_cast<double>(kPoints - 1);
  return values;
}

double gdop_at(const std::vector<RigidTransform>& world_from_sensor, const Eigen::Vector3d& point_m) {
  RangeProblem problem;
  for (const RigidTransform& sensor : world_from_sensor)
    if (problem.count < kMaxSensors && is_in_view(sensor, point_m))
      problem.sensor_m[static_cast<std::size_t>(problem.count++)] = sensor.translation_m;
  if (problem.count < 3) return kNaN;
  const std::vector<double> variance_m2(static_cast<std::size_t>(problem.count), 1.0);
  return precision_at(problem, point_m, variance_m2).gdop;
}

}  // namespace

bool is_in_view(const RigidTransform& world_from_sensor, const Eigen::Vector3d& point_in_world_m) {
  const Eigen::Vector3d p = world_from_sensor.inverse() * point_in_world_m;
  return p.z() >= kNearestView_m && p.z() <= kFarthestView_m &&
         std::abs(p.x()) <= p.z() * std::tan(kHalfWidth_rad) &&
         std::abs(p.y()) <= p.z() * std::tan(kHalfHeight_rad);
}

std::optional<GdopMap> rig_gdop(const Plan& plan) {
  const auto take = std::find_if(plan.takes.begin(), plan.takes.end(), [](const auto& t) { return t.ok; });
  if (take == plan.takes.end()) return std::nullopt;
  GdopMap map;
  map.take = take->take.id;
  map.height_m = kHeight_m;
  map.sensors = plan.rig;
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const RigidTransform& sensor : take->world_from_sensor) {
    const Eigen::Vector3d& p = sensor.translation_m;
    map.position_m.push_back({p.x(), p.y(), p.z()});
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  map.x_m = axis_over(low.x() - kAround_m, high.x() + kAround_m);
  map.z_m = axis_over(low.z() - kAround_m, high.z() + kAround_m);
  for (double z_m : map.z_m)
    for (double x_m : map.x_m) map.gdop.push_back(gdop_at(take->world_from_sensor, {x_m, kHeight_m, z_m}));
  return map;
}

}  // namespace trilat
