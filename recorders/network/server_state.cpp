// SPDX-License-Identifier: MIT
#include "recorders/network/server_state.h"

namespace trilat {
namespace {

constexpr std::size_t kMaxSmallEvents = 100'000;

std::size_t bytes_of(const SourceEvent& event) {
  std::size_t bytes = sizeof event;
  if (const auto* depth = std::get_if<EncodedDepthFrame>(&event.data)) bytes += depth->chunk.size();
  if (const auto* body = std::get_if<BodyFrame>(&event.data)) bytes += body->bodies.size() * sizeof(Body);
  return bytes;
}

}  // namespace

bool EventQueue::push_for(SourceEvent& event, std::chrono::milliseconds at_most) {
  std::unique_lock lock(mutex_);
  if (!not_full_.wait_for(lock, at_most, [&] { return closed_ || bytes_ < limit_bytes_; })) return false;
  if (closed_) return false;
  bytes_ += bytes_of(event);
  events_.push_back(std::move(event));
  not_empty_.notify_one();
  return true;
}

bool EventQueue::push_small(SourceEvent event) {
  const std::lock_guard lock(mutex_);
  if (closed_ || events_.size() >= kMaxSmallEvents) return false;
  bytes_ += bytes_of(event);
  events_.push_back(std::move(event));
  not_empty_.notify_one();
  return true;
}

std::optional<SourceEvent> EventQueue::pop() {
  std::unique_lock lock(mutex_);
  not_empty_.wait(lock, [&] { return closed_ || !events_.empty(); });
  if (events_.empty()) return std::nullopt;
  SourceEvent event = std::move(events_.front());
  events_.pop_front();
  bytes_ -= bytes_of(event);
  not_full_.notify_all();
  return event;
}

bool EventQueue::closed() const {
  const std::lock_guard lock(mutex_);
  return closed_;
}

void EventQueue::close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  not_empty_.notify_all();
  not_full_.notify_all();
}

}  // namespace trilat
