// SPDX-License-Identifier: MIT
#include "pipeline/calibration/calibrate_wand.h"

#include <array>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/version.h"
#include "evaluators/alignment/alignment.h"
#include "pipeline/study/hash_cache.h"

namespace trilat {
namespace {

// Poses in the wand's frame, in OptiTrack's world.
void put_in_world(Calibration& calibration, const WandObservations& views, const WandInWorld& world) {
  AlignmentSums sums;
  for (const ControlPoint& known :
       known_positions(world, std::span(views.positions).first(views.positions_of_first))) {
    const std::vector<StaticSighting>& seen = views.positions[known.point].seen;
    Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
    for (const StaticSighting& ball : seen)
      sum_m += calibration.sensors[ball.sensor].world_from_sensor * ball.centre_in_sensor_m;
    sums.add(sum_m / static_cast<double>(seen.size()), known.point_in_world_m);
  }
  const Alignment alignment = solve_alignment(sums, AlignmentKind::rigid);
  if (alignment.status != AlignmentStatus::aligned)
    throw InputError(world.mocap.string(),
                     "does not tie the sensors to its world: the wand's places lie on a line");
  for (SensorPose& pose : calibration.sensors)
    pose.world_from_sensor = alignment.truth_from_estimate * pose.world_from_sensor;
  calibration.world = "optitrack";
}

WandCalibration calibrate_by_two(const SessionReader& first, WandMethod method,
                                 const CalibrateWandOptions& options, WandObservations views) {
  const bool corrected = method == WandMethod::two_positions;
  const TwoPositionOptions two{
      options.trajectory_axis.value_or(corrected ? TrajectoryAxis::z : TrajectoryAxis::y), corrected,
      corrected, Eigen::Vector3d::UnitY()};
  std::vector<std::optional<FloorPlane>> floors(views.evidence.size());
  for (std::size_t s = 0; corrected && s < floors.size(); ++s) floors[s] = floor_seen_by(first, s);
  WandCalibration result;
  result.calibration = calibrate_two_positions(views, first.path().string(), two, options.baseline_m, floors);
  if (options.world) put_in_world(result.calibration, views, *options.world);
  result.views = std::move(views);
  return result;
}

const StaticSighting& ball_at(const WandObservations& views, std::size_t position, std::size_t sensor,
                              const std::string& place) {
  for (const StaticSighting& ball : views.positions[position].seen)
    if (ball.sensor == sensor) return ball;
  throw InputError(place, "sensor \"" + views.evidence[sensor].name + "\" does not see the wand's " +
                              (position == 0 ? "first" : "second") +
                              " position; two positions that all sensors see are needed");
}

}  // namespace

WandCalibration calibrate_wand(const std::vector<std::filesystem::path>& files,
                               const CalibrateWandOptions& options, WandMethod method) {
  return std::move(calibrate_wand_by(std::array{method}, files, options).front());
}

std::vector<WandCalibration> calibrate_wand_by(std::span<const WandMethod> methods,
                                               const std::vector<std::filesystem::path>& files,
                                               const CalibrateWandOptions& given) {
  CalibrateWandOptions options = given;
  std::vector<std::filesystem::path> others;  // besides the recordings
  if (options.world) others.push_back(options.world->mocap);
  WatchedFiles watched(files);
  for (const std::filesystem::path& file : others) watched.add(file);
  const std::vector<SessionReader> sessions(files.begin(), files.end());
  // before minutes of work
  if (options.world) options.world->track = read_wand_track(options.world->mocap, options.world->asset);
  const WandObservations views = view_wand(sessions, options);
  std::vector<WandCalibration> results;
  for (const WandMethod method : methods)
    results.push_back(calibrate_searched(method, sessions.front(), options, views));
  std::vector<std::filesystem::path> sources = files;
  sources.insert(sources.end(), others.begin(), others.end());
  for (const std::filesystem::path& file : sources) {
    const CalibrationSource source{file.filename().string(),
                                   hash_of_file(file, options.search.control.stop_requested)};
    for (WandCalibration& result : results) result.calibration.sources.push_back(source);
  }
  watched.check();
  return results;
}

WandCalibration calibrate_searched(WandMethod method, const SessionReader& first,
                                   const CalibrateWandOptions& options, const WandObservations& views) {
  return method == WandMethod::wand ? calibrate_views(views, first.path().string(), options)
                                    : calibrate_by_two(first, method, options, views);
}

Calibration calibrate_two_positions(const WandObservations& all_views, const std::string& place,
                                    const TwoPositionOptions& options, std::optional<double> baseline_m,
                                    std::span<const std::optional<FloorPlane>> floors) {
  WandObservations views = all_views;
  drop_unusable_positions(views);
  if (views.positions.size() < 2) throw InputError(place, "shows the wand at rest at fewer than two places");
  check_first_places(views, place);
  const std::size_t sensors = views.evidence.size();
  if (!baseline_m) {
    baseline_m = 0.0;
    for (std::size_t s = 0; s < sensors; ++s)
      *baseline_m +=
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
                            ball_at(views, 1, s, place).centre_in_sensor_m, *baseline_m, own);
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
