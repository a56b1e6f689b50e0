// SPDX-License-Identifier: MIT
#include "recorders/freenect2/depth_feed.h"

#include <algorithm>
#include <cmath>

namespace trilat {
namespace {

constexpr double kPeriodTicks = 1.0 / 30.0 / 0.125e-3;

}  // namespace

std::uint16_t depth_mm_of(float decoded_mm) {
  if (!(decoded_mm > 0.0f && decoded_mm < 65535.0f)) return 0;
  return static_cast<std::uint16_t>(std::lround(decoded_mm));
}

std::int64_t CounterUnwrap::number_of(std::uint32_t counter) {
  number_ = last_ ? number_ + static_cast<std::int32_t>(counter - *last_) : counter;
  last_ = counter;
  return number_;
}

// A frame bears the time of the frame that came after it. Where that was not its successor, the time is late
// by the periods in between, which the sequence number tells.
FrameStamp DepthFeed::stamp_of(const DecodedDepth& frame, std::int64_t arrival_ns) {
  FrameStamp stamp{sequence_.number_of(frame.sequence), ticks_.number_of(frame.timestamp), arrival_ns};
  if (last_) {
    constexpr std::int64_t kMostFrames = 100;  // beyond, the sensor's own rate counts
    const std::int64_t frames = stamp.sequence - last_->sequence;
    const double expected =
        static_cast<double>(last_->device_ticks) + static_cast<double>(frames) * kPeriodTicks;
    const double late = std::round((static_cast<double>(stamp.device_ticks) - expected) / kPeriodTicks);
    if (frames > 0 && frames <= kMostFrames && late > 0.0 && late <= kMostFrames)
      stamp.device_ticks -= std::lround(late * kPeriodTicks);
  }
  last_ = stamp;
  return stamp;
}

void DepthFeed::push(const DecodedDepth& frame, std::int64_t arrival_ns) {
  const std::lock_guard lock(mutex_);
  const bool whole = !frame.damaged && frame.depth_mm.size() == kDepthPixels;
  if (stopped_) return;
  if (!whole || frames_.size() >= limit_frames_) {
    ++lost_;
    lost_at_ns_ = arrival_ns;
  } else {
    DepthFrame& kept = frames_.emplace_back();
    kept.stamp = stamp_of(frame, arrival_ns);
    kept.depth_mm.resize(kDepthPixels);
    std::ranges::transform(frame.depth_mm, kept.depth_mm.begin(), depth_mm_of);
  }
  changed_.notify_all();
}

std::optional<SourceEvent> DepthFeed::pop(std::chrono::milliseconds at_most) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, at_most, [&] { return stopped_ || !frames_.empty() || lost_ != told_; });
  if (lost_ != told_) {
    told_ = lost_;
    return SourceEvent{0, DropCount{lost_at_ns_, lost_, 0}};
  }
  if (frames_.empty()) return std::nullopt;
  SourceEvent event{0, std::move(frames_.front())};
  frames_.pop_front();
  return event;
}

void DepthFeed::stop() {
  const std::lock_guard lock(mutex_);
  stopped_ = true;
  changed_.notify_all();
}

}  // namespace trilat
