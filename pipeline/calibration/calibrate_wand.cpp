// SPDX-License-Identifier: MIT
#include "pipeline/calibration/calibrate_wand.h"

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "datasets/base/version.h"

namespace trilat {

namespace {

WandCalibration calibrate_by_two(const WandWork& work, WandViews views) {
  const bool corrected = work.method == WandMethod::two_positions;
  const TwoPositionOptions options{
      work.options.trajectory_axis.value_or(corrected ? TrajectoryAxis::z : TrajectoryAxis::y), corrected,
      corrected, Eigen::Vector3d::UnitY()};
  std::vector<std::optional<FloorPlane>> floors;
  for (const RecordedSensor& sensor : work.recordings.front().sensors) floors.push_back(sensor.floor);
  WandCalibration result;
  result.calibration =
      calibrate_two_positions(views, work.recordings.front().place, options, work.options.movement_m, floors);
  result.views = std::move(views);
  return result;
}

const RestingBall& ball_at(const WandViews& views, std::size_t position, std::size_t sensor,
                           const std::string& place) {
  for (const RestingBall& ball : views.positions[position].seen)
    if (ball.sensor == sensor) return ball;
  throw InputError(place, "sensor \"" + views.evidence[sensor].name + "\" does not see the wand's " +
                              (position == 0 ? "first" : "second") +
                              " position; two positions that all sensors see are needed");
}

}  // namespace

WandCalibration calibrate_searched(const WandWork& work,
                                   const std::vector<std::vector<SensorSearch>>& searches) {
  WandViews views;
  for (std::size_t r = 0; r < work.recordings.size(); ++r)
    add_recording(views, work.recordings[r], searches.at(r), work.options.positions);
  WandCalibration result =
      work.method == WandMethod::wand
          ? calibrate_views(std::move(views), work.recordings.front().place, work.options)
          : calibrate_by_two(work, std::move(views));
  result.calibration.sources = sources_of(work);
  return result;
}

WandCalibration calibrate_wand(const std::vector<std::filesystem::path>& files,
                               const CalibrateWandOptions& options, WandMethod method) {
  const WatchedFiles watched = watched_files(files, options);
  const std::vector<SessionReader> sessions = open_sessions(files);
  WandWork work = make_wand_work(sessions, method, options);
  // before minutes of work
  if (WandInWorld* world = work.options.world ? &*work.options.world : nullptr; world && !world->track)
    world->track = read_wand_track(world->mocap, world->asset);
  std::vector<std::vector<SensorSearch>> searches;
  for (std::size_t r = 0; r < sessions.size(); ++r)
    searches.push_back(search_wand(sessions[r], intrinsics_of(work.recordings[r]), options.search));
  for (WandRecording& recording : work.recordings)
    recording.sha256 = hash_of_file(recording.place, options.search.watch.stop_requested);
  watched.check();
  return calibrate_searched(work, searches);
}

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
