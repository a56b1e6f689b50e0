// SPDX-License-Identifier: MIT
#include "pipeline/calibration/wand_recording.h"

#include <algorithm>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/calibration/opencv_intrinsics.h"

namespace trilat {
namespace {

void check_depth(const SessionReader& session) {
  for (std::size_t s = 0; s < session.header().sensors.size(); ++s) {
    const SensorDescription& sensor = session.header().sensors[s];
    const std::string place = session.path().string() + ":/sensors/" + sensor.name;
    if (session.counts(s).depth_frames == 0)
      throw InputError(place,
                       "has no depth frames, in which the wand could be found; `--method bodies` needs none");
    if (sensor.intrinsics.width_px != kDepthWidth || sensor.intrinsics.height_px != kDepthHeight)
      throw InputError(place, fmt::format("says that its image has {} x {} pixels; depth frames have {} x {}",
                                          sensor.intrinsics.width_px, sensor.intrinsics.height_px,
                                          kDepthWidth, kDepthHeight));
  }
}

void take_intrinsics(WandRecording& recording, const SessionReader& session, const std::string& name,
                     const std::filesystem::path& file) {
  const std::size_t sensor = session.sensor_index(name);
  for (std::size_t other = 0; other < recording.sensors.size(); ++other)
    if (other != sensor && file.parent_path().filename() == session.header().sensors[other].serial)
      throw InputError(file.string(), "lies in the folder of serial " +
                                          session.header().sensors[other].serial + ", which is sensor \"" +
                                          session.header().sensors[other].name + "\", not \"" + name + '"');
  DepthIntrinsics& intrinsics = recording.sensors[sensor].intrinsics;
  intrinsics = read_opencv_intrinsics(file, intrinsics.width_px, intrinsics.height_px);
}

}  // namespace

bool are_of_one_rig(const WandRecording& a, const WandRecording& b) {
  return std::equal(a.sensors.begin(), a.sensors.end(), b.sensors.begin(), b.sensors.end(),
                    [](const RecordedSensor& x, const RecordedSensor& y) { return x.name == y.name; });
}

std::vector<DepthIntrinsics> intrinsics_of(const WandRecording& recording) {
  std::vector<DepthIntrinsics> intrinsics;
  for (const RecordedSensor& sensor : recording.sensors) intrinsics.push_back(sensor.intrinsics);
  return intrinsics;
}

std::vector<WandRecording> read_wand_recordings(std::span<const SessionReader> sessions,
                                                const NamedIntrinsics& intrinsics, bool floors) {
  std::vector<WandRecording> recordings;
  for (const SessionReader& session : sessions) {
    check_depth(session);
    WandRecording recording{.place = session.path().string(),
                            .bytes = std::filesystem::file_size(session.path()),
                            .simulated = session.header().simulated};
    for (std::size_t s = 0; s < session.header().sensors.size(); ++s) {
      const SensorDescription& sensor = session.header().sensors[s];
      recording.sensors.push_back({sensor.name, session.counts(s).depth_frames, sensor.intrinsics});
      if (floors) recording.sensors.back().floor = floor_seen_by(session, s);
    }
    if (!recordings.empty() && !are_of_one_rig(recordings.front(), recording))
      throw InputError(recording.place,
                       "has other sensors than the first session; all recordings must be of one rig");
    for (const auto& [name, file] : intrinsics) take_intrinsics(recording, session, name, file);
    recordings.push_back(std::move(recording));
  }
  return recordings;
}

}  // namespace trilat
