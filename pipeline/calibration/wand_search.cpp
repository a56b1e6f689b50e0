// SPDX-License-Identifier: MIT
#include "pipeline/calibration/wand_search.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>

#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/session/clock/session_clock.h"
#include "pipeline/study/parallel.h"

namespace trilat {

namespace {

void add(std::vector<double>& numbers, const auto& more) {
  numbers.insert(numbers.end(), more.begin(), more.end());
}

std::size_t length_of(JsonObject& object, const std::string& key) {
  const Json& array = object.value(key);
  if (!array.is_array()) object.refuse(key, "must be an array of integers");
  return array.size();
}

Eigen::Vector3d vector_of(const std::vector<double>& numbers, std::size_t index) {
  return Eigen::Vector3d::Map(numbers.data() + 3 * index);
}

}  // namespace

void append(SensorSearch& search, const SensorSearch& next) {
  search.frames += next.frames;
  for (const auto& [status, count] : next.statuses) search.statuses[status] += count;
  for (const TimedSighting& sighting : next.found)
    if (search.found.empty() || search.found.back().time < sighting.time) search.found.push_back(sighting);
}

std::vector<FrameRun> runs_of(std::span<const std::uint64_t> frames_of_sensor, std::uint64_t length) {
  TRILAT_CHECK(length > 0 && length % kWandBlock == 0, "a run of frames is made of whole blocks");
  std::vector<FrameRun> runs;
  for (std::size_t s = 0; s < frames_of_sensor.size(); ++s)
    for (std::uint64_t first = 0; first < frames_of_sensor[s]; first += length)
      runs.push_back({s, first, std::min(length, frames_of_sensor[s] - first)});
  return runs;
}

// What all frames of a sensor need, made when the first is searched.
struct WandSearcher::Sensor {
  std::once_flag once;
  DepthRays rays;
  SensorClockMap host_from_sensor;
};

WandSearcher::WandSearcher(const SessionReader& session, std::vector<DepthIntrinsics> intrinsics,
                           const WandSearchOptions& options)
    : session_(session), intrinsics_(std::move(intrinsics)), options_(options) {
  for (std::size_t s = 0; s < intrinsics_.size(); ++s) sensors_.push_back(std::make_unique<Sensor>());
}

WandSearcher::~WandSearcher() = default;

WandSearcher::Sensor& WandSearcher::sensor(std::size_t index) {
  Sensor& sensor = *sensors_.at(index);
  std::call_once(sensor.once, [&] {
    sensor.rays = depth_rays(intrinsics_[index]);
    sensor.host_from_sensor = fit_sensor_clock(session_, index);
  });
  return sensor;
}

SensorSearch WandSearcher::search_block(const FrameRun& block, const Watch& watch) {
  const Sensor& sensor = this->sensor(block.sensor);
  SensorSearch result;
  std::vector<std::uint16_t> depth_mm(kDepthPixels);
  const std::vector<FrameStamp> stamps =
      session_.stamps(block.sensor, FrameStream::depth, block.first, block.count);
  std::optional<Eigen::Vector3d> before_m;
  for (std::uint64_t i = 0; i < block.count; ++i) {
    watch.check();
    decode_depth_frame(session_.stored_depth_frame(block.sensor, block.first + i), depth_mm);
    if (i % options_.whole_image_every == 0) before_m.reset();
    const DepthImageView image{kDepthWidth, kDepthHeight, depth_mm};
    WandSighting sighting = find_wand(image, sensor.rays, options_.find, before_m);
    if (before_m && sighting.status != WandStatus::found)
      sighting = find_wand(image, sensor.rays, options_.find);
    before_m.reset();
    SensorSearch frame{{}, {{name_of(sighting.status), 1}}, 1};
    if (sighting.status == WandStatus::found) {
      before_m = sighting.centre_in_sensor_m;
      frame.found.push_back({sensor.host_from_sensor(stamps[i]), sighting});
    }
    append(result, frame);
  }
  return result;
}

SensorSearch WandSearcher::search(const FrameRun& run, const Watch& watch) {
  std::vector<SensorSearch> blocks((run.count + kWandBlock - 1) / kWandBlock);
  std::atomic<std::uint64_t> done{0};
  parallel_for_index(blocks.size(), 1, [&](std::size_t b) {
    const std::uint64_t from = b * kWandBlock;
    const FrameRun block{run.sensor, run.first + from, std::min(kWandBlock, run.count - from)};
    blocks[b] = search_block(block, watch);
    watch.tell(static_cast<double>(done += block.count) / static_cast<double>(run.count));
  });
  SensorSearch search;
  for (const SensorSearch& block : blocks) append(search, block);
  return search;
}

std::vector<SensorSearch> search_wand(const SessionReader& session,
                                      const std::vector<DepthIntrinsics>& intrinsics,
                                      const WandSearchOptions& options) {
  std::vector<std::uint64_t> frames;
  std::uint64_t all = 0;
  for (std::size_t s = 0; s < session.header().sensors.size(); ++s)
    all += frames.emplace_back(session.counts(s).depth_frames);
  WandSearcher searcher(session, intrinsics, options);
  const std::vector<FrameRun> runs = runs_of(frames, kWandBlock);
  std::vector<SensorSearch> results(runs.size());
  std::atomic<std::uint64_t> done{0};
  parallel_for_index(runs.size(), 1, [&](std::size_t r) {
    results[r] = searcher.search(runs[r], {options.watch.stop_requested, {}});
    done += runs[r].count;
    options.watch.tell(static_cast<double>(done) / static_cast<double>(all));
  });
  std::vector<SensorSearch> searches(frames.size());
  for (std::size_t r = 0; r < runs.size(); ++r) append(searches[runs[r].sensor], results[r]);
  return searches;
}

Json json_of(const SensorSearch& search) {
  Json statuses = Json::object();
  for (const auto& [status, count] : search.statuses) statuses[status] = count;
  Json times = Json::array(), pixels = Json::array();
  std::vector<double> centres, covariances, rms;
  for (const auto& [time, sighting] : search.found) {
    times.push_back(time.ns);
    add(centres, sighting.centre_in_sensor_m);
    add(covariances, sighting.covariance_m2.reshaped());
    rms.push_back(sighting.rms_m);
    pixels.push_back(sighting.pixels);
  }
  return {{"statuses", statuses},
          {"time_ns", times},
          {"centre_in_sensor_m", numbers_json(centres)},
          {"covariance_m2", numbers_json(covariances)},
          {"rms_m", numbers_json(rms)},
          {"pixels", pixels}};
}

SensorSearch read_sensor_search(const Json& json, const std::string& place) {
  JsonObject object(json, place, "");
  SensorSearch search;
  JsonObject statuses = object.object("statuses");
  for (const std::string& status : statuses.keys())
    search.frames += search.statuses[status] = statuses.count(status);
  const std::size_t found = length_of(object, "time_ns");
  const auto times = object.integers("time_ns", found), pixels = object.integers("pixels", found);
  const auto centres = object.numbers_or_none("centre_in_sensor_m", 3 * found);
  const auto covariances = object.numbers_or_none("covariance_m2", 9 * found);
  const auto rms = object.numbers_or_none("rms_m", found);
  object.finish();
  for (std::size_t i = 0; i < found; ++i)
    search.found.push_back(
        {HostTime{times[i]},
         {WandStatus::found, vector_of(centres, i), Eigen::Matrix3d::Map(covariances.data() + 9 * i), rms[i],
          static_cast<int>(pixels[i])}});
  return search;
}

Json json_of(const WandTrack& track) {
  Json times = Json::array();
  std::vector<double> positions;
  for (const MocapTime time : track.times) times.push_back(time.ns);
  for (const Eigen::Vector3d& position_m : track.position_m) add(positions, position_m);
  return {{"time_ns", times}, {"position_m", numbers_json(positions)}};
}

WandTrack wand_track_of(const Json& json, const std::string& place) {
  JsonObject object(json, place, "");
  WandTrack track;
  const std::size_t samples = length_of(object, "time_ns");
  const auto positions = object.numbers_or_none("position_m", 3 * samples);
  for (const std::int64_t time : object.integers("time_ns", samples)) track.times.push_back({time});
  object.finish();
  for (std::size_t i = 0; i < samples; ++i) track.position_m.push_back(vector_of(positions, i));
  return track;
}

}  // namespace trilat
