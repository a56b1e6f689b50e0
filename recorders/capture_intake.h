// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "recorders/capture_queue.h"

namespace trilat {

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
