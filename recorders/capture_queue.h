// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "recorders/frame_source.h"

namespace trilat {

// Between sources, compressing workers and the writer: events leave in the order in which they came, each
// once a worker has made it ready. Bounded in bytes; what does not fit is dropped and counted, or waits.
// Everything may be called by any thread.
class CaptureQueue {
 public:
  struct Entry {
    SourceEvent event;
    std::size_t bytes = 0;
    bool ready = false;
  };

  CaptureQueue(std::size_t sensors, std::size_t limit_bytes);

  // From a source. Without `may_wait` a depth frame for which there is no room is dropped; the small events
  // are always taken.
  void push(SourceEvent event, bool may_wait);
  // Counts a frame that came in pieces.
  void drop(std::size_t sensor);
  // No more will come: workers and writer end once all has been handed out.
  void close();

  // For a worker: the next depth frame to be compressed, waiting for one; null at the end. finish() it after.
  Entry* take_work();
  void finish(Entry* entry);

  // For the writer: the next event, or nothing when none is ready by then.
  std::optional<SourceEvent> pop(std::chrono::steady_clock::time_point until);
  bool drained() const;  // closed and empty

  std::size_t bytes() const;
  std::int64_t dropped(std::size_t sensor) const;

 private:
  bool front_ready() const { return !entries_.empty() && entries_.front()->ready; }

  mutable std::mutex mutex_;
  std::condition_variable room_, work_, ready_;
  std::deque<std::unique_ptr<Entry>> entries_;
  std::size_t next_work_ = 0;  // index in entries_ of the first that no worker has looked at
  std::size_t bytes_ = 0, limit_bytes_;
  std::vector<std::int64_t> dropped_;
  bool closed_ = false;
};

// Threads that carry events of the sources into the queue and compress depth there. Ends all of them when it
// goes.
class CaptureIntake {
 public:
  CaptureIntake(const std::vector<std::unique_ptr<FrameSource>>& sources, CaptureQueue& queue,
                ChunkCompression compression, int workers);
  ~CaptureIntake();
  CaptureIntake(const CaptureIntake&) = delete;
  CaptureIntake& operator=(const CaptureIntake&) = delete;
  // Asks the sources to end.
  void stop();
  // True when a source broke before it ended.
  bool source_failed() const { return failed_; }

 private:
  void carry(FrameSource& source, std::size_t first_sensor);
  void compress(ChunkCompression compression);
  void end();

  const std::vector<std::unique_ptr<FrameSource>>& sources_;
  CaptureQueue& queue_;
  std::atomic<std::size_t> running_;
  std::atomic<bool> failed_{false};
  std::vector<std::thread> threads_;
};

}  // namespace trilat
