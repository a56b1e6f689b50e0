// SPDX-License-Identifier: MIT
#include "pipeline/calibration/wand_search.h"

#include <algorithm>
#include <atomic>

#include "datasets/base/error.h"
#include "datasets/session/session_clock.h"
#include "pipeline/parallel.h"

namespace trilat {
namespace {

constexpr std::uint64_t kBlock = 60;  // neighbouring frames that one thread searches

struct Block {
  std::size_t sensor = 0;
  std::uint64_t first = 0, count = 0;
};

struct FrameResult {
  HostTime time;
  WandSighting sighting;
};

std::vector<Block> blocks_of(const SessionReader& session) {
  std::vector<Block> blocks;
  for (std::size_t s = 0; s < session.header().sensors.size(); ++s)
    for (std::uint64_t first = 0; first < session.counts(s).depth_frames; first += kBlock)
      blocks.push_back({s, first, std::min(kBlock, session.counts(s).depth_frames - first)});
  return blocks;
}

std::vector<FrameResult> search_block(const SessionReader& session, const Block& block, const DepthRays& rays,
                                      const SensorClockMap& host_from_sensor,
                                      const WandSearchOptions& options) {
  std::vector<FrameResult> results;
  std::vector<std::uint16_t> depth_mm(kDepthPixels);
  const std::vector<FrameStamp> stamps =
      session.stamps(block.sensor, FrameStream::depth, block.first, block.count);
  std::optional<Eigen::Vector3d> before_m;
  for (std::uint64_t i = 0; i < block.count; ++i) {
    if (options.stop_requested && options.stop_requested()) throw Interrupted();
    decode_depth_frame(session.stored_depth_frame(block.sensor, block.first + i), depth_mm);
    if (i % options.whole_image_every == 0) before_m.reset();
    FrameResult result;
    result.time = host_from_sensor(stamps[i]);
    const DepthImageView image{kDepthWidth, kDepthHeight, depth_mm};
    result.sighting = find_wand(image, rays, options.find, before_m);
    if (before_m && result.sighting.status != WandStatus::found)
      result.sighting = find_wand(image, rays, options.find);
    before_m.reset();
    if (result.sighting.status == WandStatus::found) before_m = result.sighting.centre_in_sensor_m;
    results.push_back(std::move(result));
  }
  return results;
}

}  // namespace

std::vector<SensorSearch> search_wand(const SessionReader& session,
                                      const std::vector<DepthIntrinsics>& intrinsics,
                                      const WandSearchOptions& options) {
  const std::size_t sensors = session.header().sensors.size();
  std::vector<DepthRays> rays;
  std::vector<SensorClockMap> clocks;
  for (std::size_t s = 0; s < sensors; ++s) {
    rays.push_back(depth_rays(intrinsics[s]));
    clocks.push_back(session.counts(s).depth_frames > 0 ? fit_sensor_clock(session, s) : SensorClockMap{});
  }
  const std::vector<Block> blocks = blocks_of(session);
  std::vector<std::vector<FrameResult>> results(blocks.size());
  std::atomic<std::size_t> done{0};
  parallel_for_index(blocks.size(), 1, [&](std::size_t b) {
    const std::size_t s = blocks[b].sensor;
    results[b] = search_block(session, blocks[b], rays[s], clocks[s], options);
    if (options.progress) options.progress(static_cast<double>(++done) / static_cast<double>(blocks.size()));
  });
  std::vector<SensorSearch> searches(sensors);
  for (std::size_t b = 0; b < blocks.size(); ++b)
    for (const FrameResult& result : results[b]) {
      SensorSearch& search = searches[blocks[b].sensor];
      ++search.frames;
      ++search.statuses[name_of(result.sighting.status)];
      const bool rises = search.found.empty() || search.found.back().time < result.time;
      if (result.sighting.status == WandStatus::found && rises)
        search.found.push_back({result.time, result.sighting});
    }
  return searches;
}

}  // namespace trilat
