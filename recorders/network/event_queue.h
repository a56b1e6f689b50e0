// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>

#include "recorders/frame_source.h"

namespace trilat {

// Events from many threads to one, bounded by the bytes they hold. Any thread.
class EventQueue {
 public:
  explicit EventQueue(std::size_t limit_bytes) : limit_bytes_(limit_bytes) {}

  // Waits for room; false when there was none in time or the queue is closed, and `event` is as it was.
  bool push_for(SourceEvent& event, std::chrono::milliseconds at_most);
  // Never waits. False when far too many events are waiting or the queue is closed.
  bool push_small(SourceEvent event);
  // Waits for an event; nothing when the queue is closed and empty.
  std::optional<SourceEvent> pop();
  // Takes no more events.
  void close();
  bool closed() const;

 private:
  mutable std::mutex mutex_;
  std::condition_variable not_empty_, not_full_;
  std::deque<SourceEvent> events_;
  std::size_t limit_bytes_;
  std::size_t bytes_ = 0;
  bool closed_ = false;
};

}  // namespace trilat
