// SPDX-License-Identifier: MIT
#include "recorders/synthetic_source.h"

#include "datasets/base/philox.h"

namespace trilat {

SyntheticSource::SyntheticSource(SensorSpec spec, SimulatedItem item, Motion motion,
                                 std::vector<SimulatedSensor> sensors, double duration_s,
                                 const BodyTrackerSpec& tracker, std::optional<SyntheticDepth> depth)
    : spec_(spec),
      item_(item),
      motion_(std::move(motion)),
      sensors_(std::move(sensors)),
      duration_s_(duration_s),
      next_frame_(sensors_.size(), 0),
      next_exchange_(sensors_.size(), 0),
      depth_(std::move(depth)) {
  header_.simulated = true;
  header_.note = "simulated";
  for (const SimulatedSensor& sensor : sensors_) header_.sensors.push_back(description_of(sensor, spec_));
  for (const SimulatedSensor& sensor : sensors_) trackers_.emplace_back(tracker, spec_, sensor, item_);
  if (!depth_) return;
  for (SensorDescription& sensor : header_.sensors) sensor.has_depth = true;
  for (const SimulatedSensor& sensor : sensors_)
    renderers_.emplace_back(sensor.intrinsics, depth_->noise,
                            draw_depth_unit(depth_->noise, item_.seed, sensor.index));
}

std::optional<SourceEvent> SyntheticSource::exchange_of(std::size_t sensor) {
  const std::uint64_t number = next_exchange_[sensor];
  const double due_s = static_cast<double>(number) * spec_.exchange_period_s;
  const double frame_s = static_cast<double>(next_frame_[sensor]) / spec_.rate_hz;
  if (!spec_.free_running || due_s > frame_s || due_s > duration_s_) return std::nullopt;
  ++next_exchange_[sensor];
  return SourceEvent{sensor, simulate_exchange(sensors_[sensor], spec_, item_, number)};
}

std::optional<BodyFrame> SyntheticSource::simulate(std::size_t sensor, std::uint64_t frame) {
  // the tracker also sees frames that are lost on their way
  const double time_s = (exposure_of(sensors_[sensor], spec_, frame) - kMotionStart).seconds();
  const TrackedFrame tracked = trackers_[sensor].observe(frame, motion_(time_s));
  std::optional<BodyFrame> result = simulate_empty_frame(sensors_[sensor], spec_, item_, frame);
  if (!result) return std::nullopt;
  if (tracked.body) result->bodies.push_back(*tracked.body);
  return result;
}

std::optional<SourceEvent> SyntheticSource::frame_of(std::size_t sensor) {
  while (exposure_of(sensors_[sensor], spec_, next_frame_[sensor]) - kMotionStart <=
         duration_from_s(duration_s_)) {
    const std::uint64_t frame = next_frame_[sensor]++;
    if (auto result = simulate(sensor, frame)) return SourceEvent{sensor, std::move(*result)};
  }
  return std::nullopt;
}

std::optional<SourceEvent> SyntheticSource::next_without_depth() {
  // the sensor that is furthest behind delivers next
  std::vector<bool> ended(sensors_.size(), false);
  for (std::size_t tries = 0; tries < sensors_.size(); ++tries) {
    std::size_t behind = sensors_.size();
    for (std::size_t s = 0; s < sensors_.size(); ++s)
      if (!ended[s] && (behind == sensors_.size() || next_frame_[s] < next_frame_[behind])) behind = s;
    if (auto exchange = exchange_of(behind)) return exchange;
    if (auto frame = frame_of(behind)) return frame;
    ended[behind] = true;
  }
  return std::nullopt;
}

std::optional<SourceEvent> SyntheticSource::next() {
  if (!depth_) return next_without_depth();
  if (ready_.empty()) fetch_with_depth();
  if (ready_.empty()) return std::nullopt;
  SourceEvent event = std::move(ready_.front());
  ready_.pop_front();
  return event;
}

void SyntheticSource::fetch_with_depth() {
  constexpr std::size_t kFramesAtOnce = 32;  // 14 MB
  std::vector<std::size_t> to_render;
  while (to_render.size() < kFramesAtOnce) {
    auto event = next_without_depth();
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
  if (depth_->for_each) return depth_->for_each(to_render.size(), body);
  for (std::size_t i = 0; i < to_render.size(); ++i) body(i);
}

void SyntheticSource::render(SourceEvent& event) const {
  const SimulatedSensor& sensor = sensors_[event.sensor];
  auto& frame = std::get<DepthFrame>(event.data);
  const auto number = static_cast<std::uint64_t>(frame.stamp.sequence);
  const double time_s = (exposure_of(sensor, spec_, number) - kMotionStart).seconds();
  frame.depth_mm.resize(kDepthPixels);
  const RandomStream key{item_.seed, Purpose::depth_pixel, random_item(item_.take, sensor.index, 0, number)};
  renderers_[event.sensor].render(depth_->scene(time_s), sensor.pose.world_from_sensor, key, frame.depth_mm);
}

}  // namespace trilat
