// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "datasets/session/session_writer.h"
#include "recorders/capture.h"
#include "recorders/capture_queue.h"

namespace trilat {

// The writing side of a recording: stores events and knows how each sensor is. One thread.
class CaptureStore {
 public:
  using Clock = std::chrono::steady_clock;
  CaptureStore(SessionWriter& writer, const SessionHeader& header, const CaptureOptions& options);

  void add(const SourceEvent& event);
  void notice(std::size_t sensor, const std::string& text);
  // Says which sensors have sent no frame for too long.
  void look_for_silence(Clock::time_point now);
  // Stores how many frames found no room in the queue, where that has changed.
  void note_drops(const CaptureQueue& queue);
  // `period_s`: since it was last asked.
  std::vector<SensorStatus> status(double period_s);

 private:
  void heard(std::size_t sensor);

  SessionWriter& writer_;
  const CaptureOptions& options_;
  std::vector<SensorStatus> status_;
  std::vector<Clock::time_point> heard_;
  std::vector<bool> silent_;
  std::vector<std::int64_t> lost_on_the_way_;  // in an agent's queue
  std::vector<std::uint64_t> at_last_status_;
};

}  // namespace trilat
