// SPDX-License-Identifier: MIT
#include "datasets/session/arrival_envelope.h"

#include "datasets/base/check.h"

namespace trilat {

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
