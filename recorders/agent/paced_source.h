// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "recorders/frame_source.h"

namespace trilat {

// A simulated or recorded source as if it were a sensor on this machine: frames come at the pace of their
// arrival times, are stamped anew on this machine's steady clock, and do not wait. Clock exchanges of the
// source are left out: they are between other clocks.
class PacedSource : public FrameSource {
 public:
  explicit PacedSource(std::unique_ptr<FrameSource> source);
  const SessionHeader& header() const override { return source_->header(); }
  std::optional<SourceEvent> next() override;
  void stop() override;
  bool live() const override { return true; }

 private:
  // Waits for the frame's turn and stamps it; false when stopped.
  bool keep_pace(std::size_t sensor, FrameStamp& stamp);

  std::unique_ptr<FrameSource> source_;
  std::vector<std::optional<std::int64_t>> start_ns_;  // a sensor's steady time minus its recorded time
  std::mutex mutex_;
  std::condition_variable stopped_changed_;
  bool stopped_ = false;
};

}  // namespace trilat
