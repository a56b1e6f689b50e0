// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>

#include "recorders/frame_source.h"

namespace trilat {

// A sensor that is none, to try the way from an agent to a recording: 30 frames a second of a moving slope
// with one body before it, stamped with this machine's steady clock. It is marked as simulated.
class TestSource : public FrameSource {
 public:
  explicit TestSource(double duration_s);
  const SessionHeader& header() const override { return header_; }
  std::optional<SourceEvent> next() override;
  void stop() override { stopped_ = true; }
  bool live() const override { return true; }

 private:
  SessionHeader header_;
  std::int64_t frames_, frame_ = 0;
  std::int64_t start_ns_ = 0;
  std::optional<BodyFrame> bodies_;  // of the exposure whose depth has been delivered
  std::atomic<bool> stopped_{false};
};

}  // namespace trilat
