// SPDX-License-Identifier: MIT
#include "recorders/agent/paced_source.h"

#include "recorders/network/steady_time.h"

namespace trilat {
namespace {

FrameStamp* stamp_of(SourceEvent& event) {
  if (auto* bodies = std::get_if<BodyFrame>(&event.data)) return &bodies->stamp;
  if (auto* depth = std::get_if<DepthFrame>(&event.data)) return &depth->stamp;
  if (auto* depth = std::get_if<EncodedDepthFrame>(&event.data)) return &depth->stamp;
  return nullptr;
}

}  // namespace

PacedSource::PacedSource(std::unique_ptr<FrameSource> source)
    : source_(std::move(source)), start_ns_(source_->header().sensors.size()) {}

std::optional<SourceEvent> PacedSource::next() {
  while (auto event = source_->next()) {
    if (std::holds_alternative<ClockExchange>(event->data)) continue;
    FrameStamp* stamp = stamp_of(*event);
    if (stamp && !keep_pace(event->sensor, *stamp)) return std::nullopt;
    return event;
  }
  return std::nullopt;
}

bool PacedSource::keep_pace(std::size_t sensor, FrameStamp& stamp) {
  std::optional<std::int64_t>& start_ns = start_ns_.at(sensor);
  if (!start_ns) start_ns = steady_now_ns() - stamp.arrival_ns;
  const std::chrono::steady_clock::time_point due{std::chrono::nanoseconds(*start_ns + stamp.arrival_ns)};
  std::unique_lock lock(mutex_);
  if (stopped_changed_.wait_until(lock, due, [&] { return stopped_; })) return false;
  stamp.arrival_ns = steady_now_ns();
  return true;
}

void PacedSource::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    stopped_changed_.notify_all();
  }
  source_->stop();
}

}  // namespace trilat
