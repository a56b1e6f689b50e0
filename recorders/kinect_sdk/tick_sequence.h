// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace trilat {

// Numbers the frames of streams that share a device clock but carry no numbers. A gap of n periods skips
// n - 1 numbers, frames of one exposure get one number, and numbers of a stream always rise.
class TickSequence {
 public:
  TickSequence(std::size_t streams, std::int64_t period_ticks)
      : period_ticks_(period_ticks), last_(streams, -1) {}

  std::int64_t number_of(std::size_t stream, std::int64_t ticks) {
    const std::int64_t periods = last_ticks_ ? rounded_periods(ticks - *last_ticks_) : 0;
    // a step far back, or further ahead than an hour, is a sensor that began anew
    constexpr std::int64_t kMostPeriodsBack = 30, kMostPeriodsAhead = 108'000;
    const bool restarted = periods < -kMostPeriodsBack || periods > kMostPeriodsAhead;
    const std::int64_t number = std::max(restarted ? newest_ + 1 : newest_ + periods, last_[stream] + 1);
    last_[stream] = number;
    if (restarted || !last_ticks_ || periods > 0) last_ticks_ = ticks;
    newest_ = std::max(newest_, number);
    return number;
  }

 private:
  std::int64_t rounded_periods(std::int64_t ticks) const {
    const std::int64_t half = period_ticks_ / 2;
    return (ticks + (ticks < 0 ? -half : half)) / period_ticks_;
  }

  std::int64_t period_ticks_;
  std::optional<std::int64_t> last_ticks_;  // of the frame numbered newest_
  std::int64_t newest_ = 0;
  std::vector<std::int64_t> last_;
};

}  // namespace trilat
