// SPDX-License-Identifier: MIT
#include "datasets/import/frame_numbers.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace trilat {
namespace {

// 18 years of 100 ns each: later times are no clock's, and readers of sessions refuse them.
constexpr std::int64_t kLargestTicks = (std::int64_t{1} << 59) / 100;
constexpr std::int64_t kLongestGapFrames = std::int64_t{1} << 40;

void remember(LeftOut& left_out, const std::string& place, const std::string& problem) {
  if (left_out.first.empty()) left_out.first = place + " " + problem;
}

}  // namespace

void count_torn(LeftOut& left_out, const std::string& place, const TornRow& row) {
  ++left_out.torn_rows;
  remember(left_out, place, row.problem);
}

std::optional<FrameStamp> FrameNumbers::stamp(std::int64_t ticks, std::optional<std::int64_t> sequence,
                                              const std::string& place, LeftOut& left_out) {
  if (ticks < -kLargestTicks || ticks > kLargestTicks) {
    count_torn(left_out, place, {fmt::format("has the time {}, which is beyond all clocks", ticks)});
    return {};
  }
  if (last_ && ticks <= last_->device_ticks) {
    const bool repeated = ticks == last_->device_ticks;
    ++(repeated ? left_out.repeated_times : left_out.backward_times);
    remember(left_out, place,
             repeated ? "has the time of the frame before" : "has a time before that of the frame before");
    return {};
  }
  FrameStamp stamp{sequence.value_or(0), ticks, ticks * tick_ns_};
  if (last_) {
    const double elapsed_s =
        1e-9 * static_cast<double>(tick_ns_) * static_cast<double>(ticks - last_->device_ticks);
    const double periods = std::min(std::round(elapsed_s * rate_hz_), static_cast<double>(kLongestGapFrames));
    const std::int64_t step = std::max<std::int64_t>(1, static_cast<std::int64_t>(periods));
    if (!sequence || *sequence <= last_->sequence) stamp.sequence = last_->sequence + step;
    gap_frames_ += stamp.sequence - last_->sequence - 1;
  }
  last_ = stamp;
  return stamp;
}

}  // namespace trilat
