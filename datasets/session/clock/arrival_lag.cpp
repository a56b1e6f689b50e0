// SPDX-License-Identifier: MIT
#include "datasets/session/clock/arrival_lag.h"

#include <algorithm>

namespace trilat {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::int64_t kGrowth_ns = 1'000'000;
constexpr std::int64_t kLeast_ns = 250'000'000;
constexpr int kFewestSeconds = 3;

}  // namespace

void ArrivalLagFinder::end_second() {
  if (!late_ns_) return;
  if (level_ns_ && *late_ns_ > *level_ns_ + kGrowth_ns) ++growing_;
  if (!lowest_ns_ || *late_ns_ <= *lowest_ns_) {
    lowest_ns_ = late_ns_;
    growing_ = 0;
  }
  if (growing_ >= kFewestSeconds && *late_ns_ - *lowest_ns_ > kLeast_ns)
    behind_ns_ = std::max(behind_ns_, *late_ns_ - *lowest_ns_);
  level_ns_ = late_ns_;
  late_ns_.reset();
}

void ArrivalLagFinder::add(const FrameStamp& stamp) {
  const SensorTime device{stamp.device_ticks * tick_ns_};
  const std::int64_t late_ns = stamp.arrival_ns - device.ns;
  const bool restarted = late_ns_ && device < before_;
  if (!late_ns_ || restarted || device - second_ >= Duration{kSecond_ns}) {
    end_second();
    second_ = device;
  }
  if (restarted) {
    level_ns_.reset();
    lowest_ns_.reset();
    growing_ = 0;
  }
  late_ns_ = late_ns_ ? std::min(*late_ns_, late_ns) : late_ns;
  before_ = device;
}

ArrivalLag ArrivalLagFinder::finish() {
  end_second();
  return {1e-9 * static_cast<double>(behind_ns_)};
}

}  // namespace trilat
