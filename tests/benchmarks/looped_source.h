// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <vector>

#include "recorders/frame_source.h"

namespace trilat {

// What one sensor delivered, kept in memory.
struct SensorFrames {
  SensorDescription sensor;
  std::vector<BodyFrame> bodies;
  std::vector<DepthFrame> depth;  // as many, one of each a frame
};

// Takes a source to its end, sensor by sensor. Frames that have no partner of the other kind are left out.
std::vector<SensorFrames> take_all(FrameSource& source);

// The same frames of some sensors again and again at a fixed rate, stamped with this machine's clock and
// taken or not: a load whose making costs no more than a copy. Sequence numbers and ticks go on.
class LoopedSource : public FrameSource {
 public:
  LoopedSource(std::vector<std::shared_ptr<const SensorFrames>> sensors, double rate_hz, double seconds);
  const SessionHeader& header() const override { return header_; }
  std::optional<SourceEvent> next() override;
  void stop() override { stopped_ = true; }
  bool live() const override { return true; }

 private:
  FrameStamp stamp() const;

  SessionHeader header_;
  std::vector<std::shared_ptr<const SensorFrames>> sensors_;
  double rate_hz_;
  std::int64_t frames_, frame_ = 0;
  std::size_t sensor_ = 0;
  bool depth_next_ = false;
  std::chrono::steady_clock::time_point start_{};  // of the first frame
  std::atomic<bool> stopped_{false};
};

}  // namespace trilat
