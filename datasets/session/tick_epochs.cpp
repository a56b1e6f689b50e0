// SPDX-License-Identifier: MIT
#include "datasets/session/tick_epochs.h"

#include <algorithm>
#include <cstdlib>

namespace trilat {
namespace {

constexpr Duration kWindow{10'000'000'000};
constexpr Duration kStep{100'000'000};
constexpr std::int64_t kDriftDivisor = 1000;  // 1000 ppm, of the time between two frames
constexpr Duration kShortest{2'000'000'000};
constexpr std::int64_t kLongestTick_ns = 1'000'000;  // of counters that are known to wrap

// Whether ticks and arrivals go on from `a` to `b` as one clock.
bool goes_on(const ArrivalStamp& a, const ArrivalStamp& b) {
  const std::int64_t gap_ns =
      std::min(std::abs((b.device - a.device).ns), std::abs((b.arrival - a.arrival).ns));
  return std::abs((b.lateness() - a.lateness()).ns) <= kStep.ns + gap_ns / kDriftDivisor;
}

bool has_stamps(const TickEpoch& epoch) { return !epoch.windows.empty() || !epoch.doubtful.empty(); }

ArrivalStamp least_late(const ArrivalEnvelope& envelope) {
  return *std::min_element(
      envelope.hull().begin(), envelope.hull().end(),
      [](const ArrivalStamp& a, const ArrivalStamp& b) { return a.lateness() < b.lateness(); });
}
ArrivalStamp early_level(const TickEpoch& e) {
  return least_late(e.windows.empty() ? e.doubtful : e.windows.front());
}
ArrivalStamp late_level(const TickEpoch& e) {
  return least_late(e.windows.empty() ? e.doubtful : e.windows.back());
}

// Frames that were only late, beside others of the same count of ticks.
bool is_late_patch(const TickEpoch& patch, const TickEpoch* before, const TickEpoch* after) {
  if (patch.last - patch.first >= kShortest) return false;
  const bool later_than_before = before && before->last < patch.first &&
                                 late_level(*before).lateness() < early_level(patch).lateness() &&
                                 (early_level(patch).lateness() - late_level(*before).lateness()) < kShortest;
  const bool later_than_after = after && patch.last < after->first &&
                                early_level(*after).lateness() < late_level(patch).lateness() &&
                                (late_level(patch).lateness() - early_level(*after).lateness()) < kShortest;
  return later_than_before || later_than_after;
}

void join(TickEpoch& epoch, const TickEpoch& more) {
  epoch.last = std::max(epoch.last, more.last);
  epoch.wraps = std::max(epoch.wraps, more.wraps);
  epoch.frames += more.frames;
  epoch.windows.insert(epoch.windows.end(), more.windows.begin(), more.windows.end());
  for (const ArrivalStamp& stamp : more.doubtful.hull()) epoch.doubtful.add(stamp);
}

}  // namespace

void TickEpochs::add(std::int64_t device_ticks, HostTime arrival, bool certain) {
  const std::int64_t wrap_ns = kTicksOfWrap * tick_ns_;
  const auto with_wraps = [&](int wraps) {
    return ArrivalStamp{{device_ticks * tick_ns_ + wraps * wrap_ns}, arrival};
  };
  ArrivalStamp stamp = with_wraps(runs_.empty() ? 0 : runs_.back().wraps);
  if (runs_.empty() || !goes_on(before_, stamp)) {
    const bool counts_32_bits = !runs_.empty() && tick_ns_ <= kLongestTick_ns &&
                                ticks_before_ < kTicksOfWrap && device_ticks < ticks_before_;
    if (counts_32_bits && goes_on(before_, with_wraps(runs_.back().wraps + 1))) {
      stamp = with_wraps(++runs_.back().wraps);
    } else {
      stamp = with_wraps(0);
      runs_.push_back({stamp.device, stamp.device, 0, 0, {}, {}});
    }
  }
  TickEpoch& run = runs_.back();
  run.last = std::max(run.last, stamp.device);
  ++run.frames;
  before_ = stamp;
  ticks_before_ = device_ticks;
  if (!certain) {
    run.doubtful.add(stamp);
    return;
  }
  if (run.windows.empty() || stamp.device - run.windows.back().hull().front().device >= kWindow)
    run.windows.emplace_back();
  run.windows.back().add(stamp);
}

std::vector<TickEpoch> TickEpochs::finish() const {
  std::vector<TickEpoch> kept;
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    const TickEpoch* before = kept.empty() ? nullptr : &kept.back();
    const TickEpoch* after = i + 1 < runs_.size() ? &runs_[i + 1] : nullptr;
    if (!has_stamps(runs_[i]) || is_late_patch(runs_[i], before, after)) continue;
    if (before && before->last < runs_[i].first && goes_on(late_level(*before), early_level(runs_[i])))
      join(kept.back(), runs_[i]);
    else
      kept.push_back(runs_[i]);
  }
  return kept;
}

}  // namespace trilat
