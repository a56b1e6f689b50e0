// SPDX-License-Identifier: MIT
#include "pipeline/calibration/calibrate_two_positions.h"

#include "datasets/base/error.h"
#include "datasets/base/version.h"

namespace trilat {
namespace {

const RestingBall& ball_at(const WandViews& views, std::size_t position, std::size_t sensor,
                           const std::string& place) {
  for (const RestingBall& ball : views.positions[position].seen)
    if (ball.sensor == sensor) return ball;
  throw InputError(place, "sensor \"" + views.evidence[sensor].name + "\" does not see the wand's " +
                              (position == 0 ? "first" : "second") +
                              " position; two positions that all sensors see are needed");
}

}  // namespace

Calibration calibrate_two_positions(const WandViews& views, const std::string& place,
                                    const TwoPositionOptions& options, std::optional<double> movement_m,
                                    std::span<const std::optional<FloorPlane>> floors) {
  if (views.positions.size() < 2) throw InputError(place, "shows the wand at rest at fewer than two places");
  const std::size_t sensors = views.evidence.size();
  if (!movement_m) {
    movement_m = 0.0;
    for (std::size_t s = 0; s < sensors; ++s)
      *movement_m +=
          (ball_at(views, 1, s, place).centre_in_sensor_m - ball_at(views, 0, s, place).centre_in_sensor_m)
              .norm() /
          static_cast<double>(sensors);
  }
  Calibration calibration;
  calibration.method = options.translation ? "two positions, corrected" : kWithoutTranslation;
  calibration.world = "wand";
  calibration.simulated = views.simulated;
  calibration.program = kProgramVersion;
  calibration.positions = 2;
  for (std::size_t s = 0; s < sensors; ++s) {
    TwoPositionOptions own = options;
    if (floors[s]) own.up_in_sensor = floors[s]->up_in_sensor;
    const TwoPositionPose pose =
        solve_two_positions(ball_at(views, 0, s, place).centre_in_sensor_m,
                            ball_at(views, 1, s, place).centre_in_sensor_m, *movement_m, own);
    if (pose.status != TwoPositionStatus::solved)
      throw InputError(place,
                       "sensor \"" + views.evidence[s].name + "\" has no pose: " + name_of(pose.status));
    SensorPose result;
    result.name = views.evidence[s].name;
    result.world_from_sensor = pose.wand_from_sensor;
    result.used = 2;
    calibration.sensors.push_back(result);
  }
  return calibration;
}

}  // namespace trilat
