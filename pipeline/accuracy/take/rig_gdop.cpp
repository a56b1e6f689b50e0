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

// What the method says of a joint there, seen by all without any error.
SolveStatus status_at(const Method& method, const std::vector<RigidTransform>& world_from_sensor,
                      const Eigen::Vector3d& point_m) {
  std::vector<JointObservation> observations;
  for (const RigidTransform& sensor : world_from_sensor)
    observations.push_back(observe(sensor.inverse() * point_m, TrackingState::tracked, sensor));
  return evaluate(method, JointInstant{.observations = observations,
                                       .world_from_sensor = world_from_sensor,
                                       .ranges = ranges_of(observations, world_from_sensor)})
      .status;
}

const PlannedTake* first_planned(const Plan& plan) {
  const auto take = std::ranges::find_if(plan.takes, &PlannedTake::ok);
  return take == plan.takes.end() ? nullptr : &*take;
}

}  // namespace

std::vector<SilentMethod> silent_methods(const Plan& plan) {
  const PlannedTake* take = first_planned(plan);
  if (!take) return {};
  Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
  for (const RigidTransform& sensor : take->world_from_sensor)
    middle_m += sensor.translation_m / static_cast<double>(take->world_from_sensor.size());
  std::vector<SilentMethod> silent;
  for (std::size_t m = 0; m < plan.methods.size(); ++m) {
    if (is_over_time(plan.methods[m])) continue;
    SolveStatus status = SolveStatus::not_solved;
    for (const double up_m : {-0.3, 0.2, 0.5}) {
      const Eigen::Vector3d aside_m{up_m, up_m, 0.4 * up_m};  // no point that is special to the rig
      status = status_at(plan.methods[m], take->world_from_sensor, middle_m + aside_m);
      if (is_usable(status)) break;
    }
    if (!is_usable(status)) silent.push_back({m, status});
  }
  return silent;
}

bool is_in_view(const RigidTransform& world_from_sensor, const Eigen::Vector3d& point_in_world_m) {
  const Eigen::Vector3d p = world_from_sensor.inverse() * point_in_world_m;
  return p.z() >= kNearestView_m && p.z() <= kFarthestView_m &&
         std::abs(p.x()) <= p.z() * std::tan(kHalfWidth_rad) &&
         std::abs(p.y()) <= p.z() * std::tan(kHalfHeight_rad);
}

std::optional<GdopMap> rig_gdop(const Plan& plan) {
  const PlannedTake* take = first_planned(plan);
  if (!take) return std::nullopt;
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
