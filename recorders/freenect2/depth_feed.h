// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "recorders/frame_source.h"

namespace trilat {

inline constexpr std::int64_t kFreenect2TickNs = 125'000;
// libfreenect2 hands a frame over when the next one begins: at least a period after its exposure.
inline constexpr std::int64_t kFreenect2LatencyNs = 33'333'333;

// Depth as libfreenect2 decodes it, float millimetres, to what is stored; 0 where it is not positive, not
// finite, or more than 16 bits hold.
std::uint16_t depth_mm_of(float decoded_mm);

// Counters of 32 bits that overflow, to numbers that do not. Steps are taken for less than half of the range.
class CounterUnwrap {
 public:
  std::int64_t number_of(std::uint32_t counter);

 private:
  std::optional<std::uint32_t> last_;
  std::int64_t number_ = 0;
};

// A frame as libfreenect2's listener gets it; kDepthPixels values, or it is counted as lost.
struct DecodedDepth {
  std::span<const float> depth_mm;
  std::uint32_t timestamp = 0;  // of the first packet of the next frame that came, 0.125 ms
  std::uint32_t sequence = 0;
  bool damaged = false;
};

// Takes frames from the driver's thread and keeps a bounded number of them for another; the newest is lost
// where there is no room.
class DepthFeed {
 public:
  explicit DepthFeed(std::size_t limit_frames) : limit_frames_(limit_frames) {}

  void push(const DecodedDepth& frame, std::int64_t arrival_ns);
  // The next frame, or the count of lost ones where it has changed; nothing when none came in time, or at
  // once after stop().
  std::optional<SourceEvent> pop(std::chrono::milliseconds at_most);
  void stop();

 private:
  FrameStamp stamp_of(const DecodedDepth& frame, std::int64_t arrival_ns);

  std::size_t limit_frames_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<DepthFrame> frames_;
  CounterUnwrap ticks_, sequence_;
  std::optional<FrameStamp> last_;
  std::int64_t lost_ = 0, told_ = 0, lost_at_ns_ = 0;
  bool stopped_ = false;
};

}  // namespace trilat
