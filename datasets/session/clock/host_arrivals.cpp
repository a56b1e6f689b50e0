// SPDX-License-Identifier: MIT
#include "datasets/session/clock/host_arrivals.h"

#include <cstdlib>

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

}  // namespace trilat
