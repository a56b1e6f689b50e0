// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>

#include "recorders/frame_source.h"

namespace trilat {

// Sensors whose every byte follows from sensor and frame number: bodies, depth and, now and then, a clock
// exchange, frame by frame.
class PatternSource : public FrameSource {
 public:
  PatternSource(std::size_t sensors, std::int64_t frames, bool live = false, std::string first_name = "k")
      : frames_(frames), live_(live) {
    header_.simulated = true;
    for (std::size_t s = 0; s < sensors; ++s) {
      SensorDescription sensor;
      sensor.name = first_name + std::to_string(s);
      sensor.has_depth = true;
      header_.sensors.push_back(sensor);
    }
  }
  const SessionHeader& header() const override { return header_; }
  bool live() const override { return live_; }
  void stop() override { stopped_ = true; }

  std::optional<SourceEvent> next() override {
    if ((stopped_ && part_ == 0) || frame_ >= frames_) return std::nullopt;
    SourceEvent event{sensor_, {}};
    if (part_ == 0)
      event.data = bodies_of(sensor_, frame_);
    else if (part_ == 1)
      event.data = DepthFrame{stamp_of(frame_), depth_of(sensor_, frame_)};
    else
      event.data = ClockExchange{frame_, frame_ + 1, frame_ + 2, frame_ + 3};
    if (++part_ == 3) {
      part_ = 0;
      if (++sensor_ == header_.sensors.size()) {
        sensor_ = 0;
        ++frame_;
      }
    }
    return event;
  }

  static FrameStamp stamp_of(std::int64_t frame) {
    return {frame, 333'333 * frame, 33'333'300 * frame + 20'000'000};
  }
  static BodyFrame bodies_of(std::size_t sensor, std::int64_t frame) {
    BodyFrame result;
    result.stamp = stamp_of(frame);
    result.floor_plane = {0.0f, 1.0f, 0.0f, 1.0f};
    for (std::int64_t b = 0; b < frame % 3; ++b) {
      Body body;
      body.tracking_id = (std::uint64_t{1} << 56) + static_cast<std::uint64_t>(b) + 1;
      for (std::size_t j = 0; j < kJointCount; ++j) {
        body.position_m[j] = {static_cast<float>(frame), static_cast<float>(sensor), static_cast<float>(j)};
        body.tracking_state[j] = 2;
      }
      result.bodies.push_back(body);
    }
    return result;
  }
  // Random in its low bits, so that it compresses about as a real one.
  static std::vector<std::uint16_t> depth_of(std::size_t sensor, std::int64_t frame) {
    std::vector<std::uint16_t> depth(kDepthPixels);
    std::uint32_t state =
        static_cast<std::uint32_t>(frame) * 2654435761u + static_cast<std::uint32_t>(sensor) + 1;
    for (std::uint16_t& d : depth) {
      state = state * 1664525u + 1013904223u;
      d = static_cast<std::uint16_t>(2000 + (state >> 28));
    }
    return depth;
  }

 private:
  SessionHeader header_;
  std::int64_t frames_, frame_ = 0;
  std::size_t sensor_ = 0;
  int part_ = 0;
  bool live_;
  std::atomic<bool> stopped_{false};
};

}  // namespace trilat
