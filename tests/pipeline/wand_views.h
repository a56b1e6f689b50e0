// SPDX-License-Identifier: MIT
// Sightings of a wand by sensors that make no errors, and expectations on the poses that follow from them.
#pragma once

#include <functional>
#include <vector>

#include <gmock/gmock.h>

#include "datasets/base/units.h"
#include "datasets/rig/calibration.h"
#include "pipeline/calibration/calibrate_wand.h"
#include "tests/pipeline/wand_sessions.h"

namespace trilat {

inline RigidTransform wand_from_world(const std::vector<Eigen::Vector3d>& places) {
  Eigen::Matrix3d axes;
  axes.row(0) = (places[1] - places[0]).normalized();
  axes.row(2) = (places[1] - places[0]).cross(places[2] - places[0]).normalized();
  axes.row(1) = axes.row(2).cross(axes.row(0));
  const Eigen::Quaterniond rotation(axes);
  return {rotation, -(rotation * places[0])};
}

inline void expect_pose(const SensorPose& pose, const RigidTransform& truth, double limit_m,
                        double limit_deg) {
  EXPECT_LT((pose.world_from_sensor.translation_m - truth.translation_m).norm(), limit_m) << pose.name;
  EXPECT_LT(pose.world_from_sensor.rotation.angularDistance(truth.rotation), limit_deg * kRadPerDegree)
      << pose.name;
}

// Sightings of the ball at rest by sensors that make no errors.
inline WandObservations views_of(const std::vector<RigidTransform>& rig,
                                 const std::vector<Eigen::Vector3d>& places,
                                 const std::function<bool(std::size_t sensor, std::size_t place)>& sees) {
  WandObservations views;
  for (std::size_t s = 0; s < rig.size(); ++s)
    views.evidence.push_back(
        {.name = name_of_sensor(s), .frames = 90, .statuses = {{"found", 60}, {"no_wand", 30}}});
  for (std::size_t p = 0; p < places.size(); ++p) {
    WandPosition position;
    position.first = HostTime{kStart_ns + static_cast<std::int64_t>(p) * kPlaceEvery_ns};
    position.last = position.first + Duration{800'000'000};
    for (std::size_t s = 0; s < rig.size(); ++s)
      if (sees(s, p)) {
        StaticSighting ball;
        ball.sensor = s;
        ball.first = position.first;
        ball.last = position.last;
        ball.centre_in_sensor_m = rig[s].inverse() * places[p];
        ball.covariance_m2 = 1e-8 * Eigen::Matrix3d::Identity();
        ball.frames_used = 24;
        position.seen.push_back(ball);
        ++views.evidence[s].rests;
      }
    views.positions.push_back(position);
  }
  views.positions_of_first = views.positions.size();
  return views;
}

inline bool always(std::size_t, std::size_t) { return true; }

}  // namespace trilat
