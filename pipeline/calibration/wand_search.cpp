// SPDX-License-Identifier: MIT
#include "pipeline/calibration/wand_search.h"

#include <algorithm>
#include <atomic>

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
    WandSighting sighting = find_wand(image, sensor.rays, options.find, before_m);
    if (before_m && sighting.status != WandStatus::found)
      sighting = find_wand(image, sensor.rays, options.find);
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

}  // namespace trilat
