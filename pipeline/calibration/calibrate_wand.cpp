// SPDX-License-Identifier: MIT
#include "pipeline/calibration/calibrate_wand.h"

#include "datasets/base/content_hash.h"
#include "pipeline/calibration/calibrate_two_positions.h"

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

}  // namespace trilat
