// SPDX-License-Identifier: MIT
#include "pipeline/calibration/wand_views.h"

#include <algorithm>
#include <atomic>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/calibration/opencv_intrinsics.h"
#include "datasets/session/clock/session_clock.h"
#include "pipeline/study/parallel.h"

namespace trilat {

namespace {

constexpr std::uint64_t kBlock = 60;  // frames that are searched one after the other, apart from all others

// Neighbouring depth frames of one sensor.
struct FrameRun {
  std::size_t sensor = 0;
  std::uint64_t first = 0, count = 0;
};

// What all frames of a sensor need.
struct SearchedSensor {
  DepthRays rays;
  SensorClockMap host_from_sensor;
};

SensorSearch search_block(const SessionReader& session, const SearchedSensor& sensor, const FrameRun& block,
                          const WandSearchOptions& options) {
  SensorSearch result;
  std::vector<std::uint16_t> depth_mm(kDepthPixels);
  const std::vector<FrameStamp> stamps =
      session.stamps(block.sensor, FrameStream::depth, block.first, block.count);
  std::optional<Eigen::Vector3d> before_m;
  for (std::uint64_t i = 0; i < block.count; ++i) {
    options.watch.check();
    decode_depth_frame(session.stored_depth_frame(block.sensor, block.first + i), depth_mm);
    if (i % options.whole_image_every == 0) before_m.reset();
    const DepthImageView image{kDepthWidth, kDepthHeight, depth_mm};
    const WandSighting sighting = follow_wand(image, sensor.rays, options.find, before_m);
    SensorSearch frame{{}, {{name_of(sighting.status), 1}}, 1};
    if (sighting.status == WandStatus::found)
      frame.found.push_back({sensor.host_from_sensor(stamps[i]), sighting});
    append(result, frame);
  }
  return result;
}

}  // namespace

void append(SensorSearch& search, const SensorSearch& next) {
  search.frames += next.frames;
  for (const auto& [status, count] : next.statuses) search.statuses[status] += count;
  for (const TimedSighting& sighting : next.found)
    if (search.found.empty() || search.found.back().time < sighting.time) search.found.push_back(sighting);
}

std::vector<SensorSearch> search_wand(const SessionReader& session,
                                      const std::vector<DepthIntrinsics>& intrinsics,
                                      const WandSearchOptions& options) {
  std::vector<SearchedSensor> sensors(session.header().sensors.size());
  std::vector<FrameRun> blocks;
  std::uint64_t all = 0;
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    const std::uint64_t frames = session.counts(s).depth_frames;
    sensors[s] = {depth_rays(intrinsics[s]), fit_sensor_clock(session, s)};
    for (std::uint64_t first = 0; first < frames; first += kBlock)
      blocks.push_back({s, first, std::min(kBlock, frames - first)});
    all += frames;
  }
  std::vector<SensorSearch> results(blocks.size());
  std::atomic<std::uint64_t> done{0};
  parallel_for_index(blocks.size(), 1, [&](std::size_t b) {
    results[b] = search_block(session, sensors[blocks[b].sensor], blocks[b], options);
    options.watch.tell(static_cast<double>(done += blocks[b].count) / static_cast<double>(all));
  });
  std::vector<SensorSearch> searches(sensors.size());
  for (std::size_t b = 0; b < blocks.size(); ++b) append(searches[blocks[b].sensor], results[b]);
  return searches;
}

namespace {

void add_evidence(SensorEvidence& evidence, const SensorSearch& search,
                  const std::vector<RestingBall>& rests) {
  evidence.frames += search.frames;
  for (const auto& [name, count] : search.statuses) evidence.statuses[name] += count;
  for (const RestingBall& ball : rests) {
    const double distance_m = ball.centre_in_sensor_m.norm();
    evidence.nearest_m = evidence.rests == 0 ? distance_m : std::min(evidence.nearest_m, distance_m);
    evidence.farthest_m = std::max(evidence.farthest_m, distance_m);
    ++evidence.rests;
  }
}

// Whether a sensor that saw both saw the ball in one place.
bool are_one_place(const WandPosition& a, const WandPosition& b, double within_m) {
  for (const RestingBall& one : a.seen)
    for (const RestingBall& other : b.seen)
      if (one.sensor == other.sensor)
        return (one.centre_in_sensor_m - other.centre_in_sensor_m).norm() < within_m;
  return false;
}

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

void add_recording(WandViews& views, const WandRecording& recording, std::span<const SensorSearch> searches,
                   const WandPositionOptions& options) {
  const bool first = views.evidence.empty();
  if (first)
    for (const RecordedSensor& sensor : recording.sensors)
      views.evidence.push_back({.name = sensor.name, .statuses = {}});
  std::vector<RestingBall> rests;
  for (std::size_t s = 0; s < searches.size(); ++s) {
    const std::vector<RestingBall> more = find_rests(searches[s].found, s, options);
    add_evidence(views.evidence[s], searches[s], more);
    rests.insert(rests.end(), more.begin(), more.end());
  }
  // One recording at a time: the host clocks of two need not be the same.
  auto positions = find_wand_positions(std::move(rests), options);
  views.positions.insert(views.positions.end(), positions.begin(), positions.end());
  views.simulated = views.simulated || recording.simulated;
  if (first) views.positions_of_first = views.positions.size();
}

std::vector<bool> sensors_that_saw(const WandViews& views) {
  std::vector<bool> saw(views.evidence.size(), false);
  for (const WandPosition& position : views.positions)
    for (const RestingBall& ball : position.seen) saw[ball.sensor] = true;
  return saw;
}

// Places that only one sensor saw say nothing of where it stands beside the others, and a hand that drifts
// may make two rests of one place.
void keep_useful_positions(WandViews& views) {
  constexpr double kSamePlace_m = 0.05;
  std::vector<WandPosition> kept;
  std::size_t kept_of_first = 0;
  for (std::size_t p = 0; p < views.positions.size(); ++p) {
    const WandPosition& position = views.positions[p];
    const bool again = !kept.empty() && are_one_place(kept.back(), position, kSamePlace_m);
    if (again || (position.seen.size() < 2 && views.evidence.size() > 1)) continue;
    kept.push_back(position);
    if (p < views.positions_of_first) kept_of_first = kept.size();
  }
  views.positions = std::move(kept);
  views.positions_of_first = kept_of_first;
}

std::optional<double> seen_movement_m(const WandViews& views) {
  double sum_m = 0.0, count = 0.0;
  for (const RestingBall& first : views.positions[0].seen)
    for (const RestingBall& second : views.positions[1].seen)
      if (first.sensor == second.sensor) {
        sum_m += (second.centre_in_sensor_m - first.centre_in_sensor_m).norm();
        count += 1.0;
      }
  if (count == 0.0) return std::nullopt;
  return sum_m / count;
}

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
    WandRecording recording{.place = session.path().string(), .simulated = session.header().simulated};
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
