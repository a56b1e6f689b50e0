// SPDX-License-Identifier: MIT
#include "evaluators/fusion/baselines.h"

#include "datasets/base/error.h"

namespace trilat {
namespace {

PointEstimate baseline_at(const Eigen::Vector3d& position_m) {
  if (!position_m.allFinite()) return failed_estimate(SolveStatus::non_finite_input);
  PointEstimate result;
  result.position_m = position_m;
  result.status = SolveStatus::closed_form;
  return result;
}

}  // namespace

PointEstimate solve_single_sensor(std::span<const JointObservation> observations,
                                  const SingleSensorOptions& options) {
  TRILAT_CHECK(options.sensor >= 0 && static_cast<std::size_t>(options.sensor) < observations.size(),
               "the rig has the sensor");
  const JointObservation& observation = observations[options.sensor];
  return observation.seen ? baseline_at(observation.point_in_world_m)
                          : failed_estimate(SolveStatus::no_observation);
}

PointEstimate solve_mean(std::span<const JointObservation> observations, const MeanOptions& options) {
  TRILAT_CHECK(observations.size() <= kMaxSensors, "the rig is within the capacity");
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d tracked_sum_m = Eigen::Vector3d::Zero();
  int seen = 0;
  int tracked = 0;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (!options.allowed[i] || !observations[i].seen) continue;
    sum_m += observations[i].point_in_world_m;
    ++seen;
    if (observations[i].state != TrackingState::tracked) continue;
    tracked_sum_m += observations[i].point_in_world_m;
    ++tracked;
  }
  if (seen == 0) return failed_estimate(SolveStatus::no_observation);
  if (options.prefer_tracked && tracked > 0) return baseline_at(tracked_sum_m / tracked);
  return baseline_at(sum_m / seen);
}

}  // namespace trilat
