// SPDX-License-Identifier: MIT
#include "recorders/live_source.h"

#include <chrono>

#include "datasets/base/time.h"
#include "recorders/frame_source.h"

namespace trilat {
namespace {

FrameStamp* stamp_of(SourceEvent& event) {
  if (auto* frame = std::get_if<BodyFrame>(&event.data)) return &frame->stamp;
  if (auto* frame = std::get_if<DepthFrame>(&event.data)) return &frame->stamp;
  if (auto* frame = std::get_if<EncodedDepthFrame>(&event.data)) return &frame->stamp;
  return nullptr;
}

}  // namespace

LiveSource::LiveSource(std::unique_ptr<FrameSource> inner, const LiveOptions& options)
    : inner_(std::move(inner)),
      options_(options),
      first_arrival_ns_(inner_->header().sensors.size()),
      lost_(first_arrival_ns_.size(), 0),
      last_lost_(first_arrival_ns_.size(), -1) {}

std::int64_t LiveSource::start() {
  if (!start_ns_) {
    look_ahead();  // what is due first is made before the clock starts
    start_ns_ = host_now_ns();
  }
  return *start_ns_;
}

void LiveSource::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  stop_changed_.notify_all();
  inner_->stop();
}

std::int64_t LiveSource::due_ns(const SourceEvent& event) {
  auto& first = first_arrival_ns_.at(event.sensor);
  if (const auto* exchange = std::get_if<ClockExchange>(&event.data))
    return exchange->t4_ns - options_.origin_ns;
  if (const FrameStamp* stamp = stamp_of(const_cast<SourceEvent&>(event))) {
    // arrivals may be on a clock of another machine, whose first frame comes near the start
    if (!first) first = stamp->arrival_ns;
    return options_.one_clock ? stamp->arrival_ns - options_.origin_ns : stamp->arrival_ns - *first;
  }
  return 0;
}

bool LiveSource::wait_until(std::int64_t host_ns) {
  std::unique_lock lock(mutex_);
  stop_changed_.wait_for(lock, std::chrono::nanoseconds(host_ns - host_now_ns()), [&] { return stopped_; });
  return !stopped_;
}

void LiveSource::move_to_now(SourceEvent& event) const {
  const std::int64_t by_ns = *start_ns_ - options_.origin_ns;
  if (FrameStamp* stamp = stamp_of(event))
    stamp->arrival_ns = options_.stamp_arrivals ? host_now_ns() : stamp->arrival_ns + by_ns;
  if (auto* e = std::get_if<ClockExchange>(&event.data))
    for (std::int64_t* t : {&e->t1_ns, &e->t2_ns, &e->t3_ns, &e->t4_ns}) *t += by_ns;
  if (auto* count = std::get_if<DropCount>(&event.data)) count->host_ns += by_ns;
}

void LiveSource::look_ahead() {
  // bodies, depth and an exchange of every sensor, for two frame numbers
  const std::size_t events_ahead = 6 * header().sensors.size();
  while (ahead_.size() < events_ahead) {
    std::optional<SourceEvent> event = inner_->next();
    if (!event) return;
    // an exchange with the clock of a simulated machine says nothing about stamps of this one
    if (options_.stamp_arrivals && std::holds_alternative<ClockExchange>(event->data)) continue;
    const std::int64_t due = due_ns(*event);
    ahead_.emplace(due, std::move(*event));
  }
}

std::optional<std::pair<std::int64_t, SourceEvent>> LiveSource::earliest() {
  look_ahead();
  if (ahead_.empty()) return std::nullopt;
  auto node = ahead_.extract(ahead_.begin());
  return std::pair{node.key(), std::move(node.mapped())};
}

bool LiveSource::too_late(const SourceEvent& event, std::int64_t due_host_ns) const {
  constexpr std::int64_t kLate_ns = 200'000'000;  // six frames
  return options_.stamp_arrivals && stamp_of(const_cast<SourceEvent&>(event)) &&
         host_now_ns() - due_host_ns > kLate_ns;
}

// A frame whose bodies and depth are both lost is lost once.
SourceEvent LiveSource::lost(const SourceEvent& event) {
  const std::size_t s = event.sensor;
  const std::int64_t number = stamp_of(const_cast<SourceEvent&>(event))->sequence;
  if (number != last_lost_[s]) ++lost_[s];
  last_lost_[s] = number;
  return {s, DropCount{host_now_ns(), lost_[s], 0}};
}

std::optional<SourceEvent> LiveSource::next() {
  {
    const std::lock_guard lock(mutex_);
    if (stopped_) return std::nullopt;
  }
  const std::int64_t start_ns = start();
  auto first = earliest();
  if (!first) return std::nullopt;
  auto& [due, event] = *first;
  const std::int64_t due_host_ns =
      options_.speed > 0.0 ? start_ns + static_cast<std::int64_t>(static_cast<double>(due) / options_.speed)
                           : 0;
  if (options_.speed > 0.0 && !wait_until(due_host_ns)) return std::nullopt;
  if (too_late(event, due_host_ns)) return lost(event);
  move_to_now(event);
  return std::move(event);
}

}  // namespace trilat
