// SPDX-License-Identifier: MIT
#include "recorders/synthetic_depth_source.h"

#include "datasets/base/philox.h"

namespace trilat {
namespace {

constexpr std::size_t kFramesAtOnce = 32;  // 14 MB

}  // namespace

SyntheticDepthSource::SyntheticDepthSource(SensorSpec spec, SimulatedItem item, Motion motion,
                                           std::vector<SimulatedSensor> sensors, double duration_s,
                                           SyntheticDepth depth, SyntheticTracker tracker)
    : spec_(spec),
      item_(item),
      sensors_(std::move(sensors)),
      depth_(std::move(depth)),
      bodies_(spec, item, std::move(motion), sensors_, duration_s, std::move(tracker)),
      header_(bodies_.header()) {
  for (SensorDescription& sensor : header_.sensors) sensor.has_depth = true;
  for (const SimulatedSensor& sensor : sensors_)
    renderers_.emplace_back(sensor.intrinsics, depth_.noise,
                            draw_depth_unit(depth_.noise, item_.seed, sensor.index));
}

std::optional<SourceEvent> SyntheticDepthSource::next() {
  if (ready_.empty()) fetch();
  if (ready_.empty()) return std::nullopt;
  SourceEvent event = std::move(ready_.front());
  ready_.pop_front();
  return event;
}

void SyntheticDepthSource::fetch() {
  std::vector<std::size_t> to_render;
  while (to_render.size() < kFramesAtOnce) {
    auto event = bodies_.next();
    if (!event) break;
    const std::size_t sensor = event->sensor;
    const auto* frame = std::get_if<BodyFrame>(&event->data);
    std::optional<DepthFrame> depth;
    if (frame) depth = DepthFrame{frame->stamp, {}};
    ready_.push_back(std::move(*event));
    if (!depth) continue;
    to_render.push_back(ready_.size());
    ready_.push_back({sensor, std::move(*depth)});
  }
  const auto body = [&](std::size_t i) { render(ready_[to_render[i]]); };
  if (depth_.for_each) return depth_.for_each(to_render.size(), body);
  for (std::size_t i = 0; i < to_render.size(); ++i) body(i);
}

void SyntheticDepthSource::render(SourceEvent& event) const {
  const SimulatedSensor& sensor = sensors_[event.sensor];
  auto& frame = std::get<DepthFrame>(event.data);
  const auto number = static_cast<std::uint64_t>(frame.stamp.sequence);
  const double time_s = (exposure_of(sensor, spec_, number) - kMotionStart).seconds();
  frame.depth_mm.resize(kDepthPixels);
  const RandomStream key{item_.seed, Purpose::depth_pixel, random_item(item_.take, sensor.index, 0, number)};
  renderers_[event.sensor].render(depth_.scene(time_s), sensor.pose.world_from_sensor, key, frame.depth_mm);
}

}  // namespace trilat
