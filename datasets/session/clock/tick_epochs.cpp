// SPDX-License-Identifier: MIT
#include "datasets/session/clock/tick_epochs.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "datasets/base/error.h"

namespace trilat {
namespace {

constexpr Duration kSlack{100'000'000};

}  // namespace

// Somewhere between the last exchange of one setting and the first of the next the clock was set.
bool HostArrivals::can_be(std::size_t segment, AgentTime arrival) const {
  const auto& segments = clock_->segments;
  const auto unseen = [&](std::size_t before) {
    return segments[before + 1].host_from_agent(segments[before + 1].first) -
           segments[before].host_from_agent(segments[before].last) + kSlack;
  };
  if (segment > 0 && arrival < segments[segment].first - unseen(segment - 1)) return false;
  if (segment + 1 < segments.size() && arrival > segments[segment].last + unseen(segment)) return false;
  return !before_ || segments[segment].host_from_agent(arrival) >= before_->arrival - kSlack;
}

HostArrival HostArrivals::chosen(SensorTime device, AgentTime arrival) {
  const auto& segments = clock_->segments;
  std::size_t next_possible = segment_;
  while (next_possible < segments.size() && !can_be(next_possible, arrival)) ++next_possible;
  if (next_possible < segments.size()) segment_ = next_possible;
  const HostTime here = segments[segment_].host_from_agent(arrival);
  const bool open = segment_ + 1 < segments.size() && can_be(segment_ + 1, arrival);
  if (!open) return {here, segment_ == 0 || arrival >= segments[segment_].first};
  const HostTime next = segments[segment_ + 1].host_from_agent(arrival);
  const auto step_ns = [&](HostTime t) {
    return before_ ? std::abs((ArrivalStamp{device, t}.lateness() - before_->lateness()).ns) : 0;
  };
  if (step_ns(next) >= step_ns(here)) return {here, false};
  ++segment_;
  return {next, false};
}

HostArrival HostArrivals::place(SensorTime device, AgentTime arrival) {
  if (clock_->segments.empty()) return {{arrival.ns}, true};
  const HostArrival placed = chosen(device, arrival);
  before_ = ArrivalStamp{device, placed.time};
  return placed;
}

void ArrivalEnvelope::add(const ArrivalStamp& p) {
  if (!hull_.empty() && p.device <= hull_.back().device) return;
  // slopes near one: compare arrival - device, which keeps the digits
  const auto turns_up = [](const ArrivalStamp& a, const ArrivalStamp& b, const ArrivalStamp& c) {
    const double ab = static_cast<double>((b.device - a.device).ns);
    const double ac = static_cast<double>((c.device - a.device).ns);
    const double lag_b = static_cast<double>((b.lateness() - a.lateness()).ns);
    const double lag_c = static_cast<double>((c.lateness() - a.lateness()).ns);
    return lag_b * ac < lag_c * ab;
  };
  while (hull_.size() >= 2 && !turns_up(hull_[hull_.size() - 2], hull_.back(), p)) hull_.pop_back();
  hull_.push_back(p);
}

ClockMap<HostClock, SensorClock> ArrivalEnvelope::line() const {
  TRILAT_CHECK(!hull_.empty(), "an envelope has points");
  if (hull_.size() == 1) return {hull_[0].device, hull_[0].arrival, 0.0};
  const SensorTime middle{hull_.front().device.ns + (hull_.back().device - hull_.front().device).ns / 2};
  std::size_t right = 1;
  while (right + 1 < hull_.size() && hull_[right].device < middle) ++right;
  const ArrivalStamp& a = hull_[right - 1];
  const ArrivalStamp& b = hull_[right];
  const double drift =
      static_cast<double>((b.lateness() - a.lateness()).ns) / static_cast<double>((b.device - a.device).ns);
  return {a.device, a.arrival, drift};
}

namespace {

constexpr Duration kWindow{10'000'000'000};
constexpr Duration kStep{100'000'000};
constexpr std::int64_t kDriftDivisor = 1000;  // 1000 ppm, of the time between two frames
constexpr Duration kShortest{2'000'000'000};

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
  epoch.frames += more.frames;
  epoch.windows.insert(epoch.windows.end(), more.windows.begin(), more.windows.end());
  for (const ArrivalStamp& stamp : more.doubtful.hull()) epoch.doubtful.add(stamp);
}

using SensorLine = ClockMap<HostClock, SensorClock>;

constexpr double kMaxLineDrift = 1e-3;
constexpr Duration kShortestPiece{5'000'000'000};
constexpr Duration kShortestDriftSpan{10'000'000'000};
constexpr double kStraightPiece_ns = 300'000.0;
constexpr double kFastestPieceWander = 50e-6;  // change of a clock against its own straight line
constexpr std::size_t kFewestWindows = 3;

ArrivalEnvelope whole_envelope(const TickEpoch& epoch) {
  ArrivalEnvelope whole;
  for (const ArrivalEnvelope& window : epoch.windows)
    for (const ArrivalStamp& stamp : window.hull()) whole.add(stamp);
  return whole.empty() ? epoch.doubtful : whole;
}

// The frame of a window that is least late, and by how much.
struct LeastLate {
  ArrivalStamp stamp;
  double late_ns = 0.0;
};

LeastLate least_late(const ArrivalEnvelope& envelope, const SensorLine& line) {
  LeastLate least{{}, std::numeric_limits<double>::infinity()};
  for (const ArrivalStamp& stamp : envelope.hull()) {
    const auto late_ns = static_cast<double>((stamp.arrival - line(stamp.device)).ns);
    if (late_ns < least.late_ns) least = {stamp, late_ns};
  }
  return least;
}

// Without those that are later than the rest allow.
std::vector<LeastLate> punctual(const std::vector<LeastLate>& all) {
  std::vector<double> most_ns;  // from the windows before, then also from those after
  const auto limit = [](double late_ns, Duration away) {
    return late_ns + kFastestPieceWander * static_cast<double>(away.ns);
  };
  for (std::size_t i = 0; i < all.size(); ++i)
    most_ns.push_back(i == 0 ? all[i].late_ns
                             : std::min(all[i].late_ns, limit(most_ns[i - 1], all[i].stamp.device -
                                                                                  all[i - 1].stamp.device)));
  for (std::size_t i = all.size() - 1; i-- > 0;)
    most_ns[i] = std::min(most_ns[i], limit(most_ns[i + 1], all[i + 1].stamp.device - all[i].stamp.device));
  std::vector<LeastLate> kept;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all[i].late_ns <= most_ns[i]) kept.push_back(all[i]);
  return kept;
}

bool is_straight(const std::vector<LeastLate>& windows) {
  return std::ranges::none_of(windows,
                              [](const LeastLate& w) { return std::abs(w.late_ns) > kStraightPiece_ns; });
}

}  // namespace

void TickEpochs::add(std::int64_t device_ticks, HostTime arrival, bool certain) {
  const ArrivalStamp stamp{{device_ticks * tick_ns_}, arrival};
  if (runs_.empty() || !goes_on(before_, stamp)) runs_.push_back({stamp.device, stamp.device, 0, {}, {}});
  TickEpoch& run = runs_.back();
  run.last = std::max(run.last, stamp.device);
  ++run.frames;
  before_ = stamp;
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

SensorLine envelope_line(const TickEpoch& epoch) {
  SensorLine line = whole_envelope(epoch).line();
  if (drift_left_out(epoch) != 0.0) line.drift = 0.0;
  return line;
}

double drift_left_out(const TickEpoch& epoch) {
  const double drift = whole_envelope(epoch).line().drift;
  return std::abs(drift) > kMaxLineDrift && epoch.last - epoch.first < kShortestPiece ? drift : 0.0;
}

SensorLine envelope_line(const TickEpoch& epoch, double drift_of_short) {
  if (epoch.last - epoch.first >= kShortestDriftSpan) return envelope_line(epoch);
  const ArrivalEnvelope whole = whole_envelope(epoch);
  const ArrivalStamp& first = whole.hull().front();
  const SensorLine through_first{first.device, first.arrival, drift_of_short};
  const ArrivalStamp least = least_late(whole, through_first).stamp;
  return {least.device, least.arrival, drift_of_short};
}

PiecewiseClock<HostClock, SensorClock> envelope_pieces(const TickEpoch& epoch, const SensorLine& line) {
  if (epoch.windows.size() < kFewestWindows) return along(line);
  std::vector<LeastLate> windows;
  for (const ArrivalEnvelope& window : epoch.windows) windows.push_back(least_late(window, line));
  windows = punctual(windows);
  if (is_straight(windows)) return along(line);
  std::vector<ClockKnot<HostClock, SensorClock>> knots;
  for (const LeastLate& w : windows)
    if (knots.empty() || w.stamp.device > knots.back().from)
      knots.push_back({w.stamp.device, w.stamp.arrival});
  return through(knots, line);
}

}  // namespace trilat
