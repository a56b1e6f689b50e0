// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <compare>
#include <cstdint>

namespace trilat {

// A length of time in nanoseconds. 64 bits hold 292 years.
struct Duration {
  std::int64_t ns = 0;
  friend constexpr auto operator<=>(Duration, Duration) = default;
  friend constexpr Duration operator+(Duration a, Duration b) { return {a.ns + b.ns}; }
  friend constexpr Duration operator-(Duration a, Duration b) { return {a.ns - b.ns}; }
  friend constexpr Duration operator-(Duration a) { return {-a.ns}; }
  constexpr double seconds() const { return static_cast<double>(ns) * 1e-9; }
};

// Rounds to the nearest nanosecond.
inline Duration duration_from_s(double seconds) {
  return {static_cast<std::int64_t>(std::llround(seconds * 1e9))};
}

// The clocks a recording knows. A sensor's clock starts at an arbitrary origin and drifts; the host clock is
// the monotonic clock of the recording machine; the mocap clock is zero at the first frame of the OptiTrack
// take.
struct SensorClock {};
struct HostClock {};
struct MocapClock {};

// An instant on one clock. Instants of two clocks can be neither compared nor subtracted: that does not
// compile.
template <class Clock>
struct Instant {
  std::int64_t ns = 0;
  friend constexpr auto operator<=>(Instant, Instant) = default;
  friend constexpr Duration operator-(Instant a, Instant b) { return {a.ns - b.ns}; }
  friend constexpr Instant operator+(Instant a, Duration d) { return {a.ns + d.ns}; }
  friend constexpr Instant operator-(Instant a, Duration d) { return {a.ns - d.ns}; }
};

using SensorTime = Instant<SensorClock>;
using HostTime = Instant<HostClock>;
using MocapTime = Instant<MocapClock>;

// to = origin_to + (1 + drift) (from - origin_from). Origins are kept as integers, so that a nanosecond
// survives however long the machine has been up.
template <class To, class From>
struct ClockMap {
  Instant<From> origin_from;
  Instant<To> origin_to;
  double drift = 0.0;

  Instant<To> operator()(Instant<From> t) const {
    const Duration since = t - origin_from;
    return origin_to + since +
           Duration{static_cast<std::int64_t>(std::llround(drift * static_cast<double>(since.ns)))};
  }
  ClockMap<From, To> inverse() const { return {origin_to, origin_from, -drift / (1.0 + drift)}; }
};

}  // namespace trilat
