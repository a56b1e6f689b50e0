// SPDX-License-Identifier: MIT
#include "tests/benchmarks/looped_source.h"

#include <map>
#include <thread>

#include "datasets/base/error.h"
#include "recorders/frame_source.h"

namespace trilat {

std::vector<SensorFrames> take_all(FrameSource& source) {
  const std::size_t sensors = source.header().sensors.size();
  std::vector<std::map<std::int64_t, BodyFrame>> bodies(sensors);
  std::vector<SensorFrames> result(sensors);
  for (std::size_t s = 0; s < sensors; ++s) result[s].sensor = source.header().sensors[s];
  while (auto event = source.next()) {
    if (auto* frame = std::get_if<BodyFrame>(&event->data))
      bodies[event->sensor].emplace(frame->stamp.sequence, std::move(*frame));
    if (auto* depth = std::get_if<DepthFrame>(&event->data))
      result[event->sensor].depth.push_back(std::move(*depth));
  }
  for (std::size_t s = 0; s < sensors; ++s) {
    std::erase_if(result[s].depth,
                  [&](const DepthFrame& d) { return !bodies[s].contains(d.stamp.sequence); });
    for (const DepthFrame& d : result[s].depth)
      result[s].bodies.push_back(std::move(bodies[s].at(d.stamp.sequence)));
  }
  return result;
}

LoopedSource::LoopedSource(std::vector<std::shared_ptr<const SensorFrames>> sensors, double rate_hz,
                           double seconds)
    : sensors_(std::move(sensors)), rate_hz_(rate_hz), frames_(static_cast<std::int64_t>(seconds * rate_hz)) {
  header_.simulated = true;
  header_.note = "simulated";
  for (const auto& sensor : sensors_) {
    TRILAT_CHECK(!sensor->depth.empty(), "a looped sensor has frames");
    header_.sensors.push_back(sensor->sensor);
  }
}

FrameStamp LoopedSource::stamp() const {
  const double tick_ns = static_cast<double>(header_.sensors[sensor_].tick_ns);
  return {frame_, static_cast<std::int64_t>(1e9 * static_cast<double>(frame_) / (rate_hz_ * tick_ns)),
          steady_now_ns()};
}

std::optional<SourceEvent> LoopedSource::next() {
  using Clock = std::chrono::steady_clock;
  if (stopped_ || frame_ >= frames_) return std::nullopt;
  if (start_ == Clock::time_point{}) start_ = Clock::now();
  if (sensor_ == 0 && !depth_next_)
    std::this_thread::sleep_until(start_ +
                                  std::chrono::duration_cast<Clock::duration>(
                                      std::chrono::duration<double>(static_cast<double>(frame_) / rate_hz_)));
  const SensorFrames& frames = *sensors_[sensor_];
  const std::size_t which = static_cast<std::size_t>(frame_) % frames.depth.size();
  SourceEvent event{sensor_, {}};
  if (depth_next_)
    event.data = DepthFrame{stamp(), frames.depth[which].depth_mm};
  else
    event.data = BodyFrame{stamp(), frames.bodies[which].floor_plane, frames.bodies[which].bodies};
  depth_next_ = !depth_next_;
  if (!depth_next_ && ++sensor_ == sensors_.size()) {
    sensor_ = 0;
    ++frame_;
  }
  return event;
}

}  // namespace trilat
