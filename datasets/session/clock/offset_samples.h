// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "datasets/session/session_types.h"

namespace trilat {

// What one exchange says of agent - host, taking its delays as alike both ways.
struct OffsetSample {
  std::int64_t host_ns = 0;  // midpoint of the exchange on the host
  double offset_ns = 0.0;    // less a base of the caller's
};

std::int64_t twice_offset_ns(const ClockExchange& exchange);
std::vector<OffsetSample> samples_of(const std::vector<ClockExchange>& exchanges, std::int64_t base_ns);

// The quarter of least delay, but three at least, by t1: those that queueing disturbed least.
std::vector<ClockExchange> least_delayed(std::vector<ClockExchange> exchanges);

// offset = intercept + slope (host - origin)
struct OffsetLine {
  std::int64_t origin_ns = 0;
  double intercept_ns = 0.0;
  double slope = 0.0;
};
std::vector<double> residuals_of(const std::vector<OffsetSample>& samples, const OffsetLine& line);

// Median of the slopes between samples at least a third of the span apart; bounded work for long recordings.
// Samples by time.
double median_slope(const std::vector<OffsetSample>& samples);

// Standard deviation of normal values with this median absolute deviation from `middle`.
double sigma_of(const std::vector<double>& values, double middle);
// Of the median of `count` normal values.
double sigma_of_median(double sigma, std::size_t count);

// Time that an exchange spent on the wire, both ways.
inline std::int64_t delay_ns(const ClockExchange& e) { return (e.t4_ns - e.t1_ns) - (e.t3_ns - e.t2_ns); }

// False when it was answered before it was sent, or took longer to answer than it was away.
inline bool runs_forwards(const ClockExchange& e) {
  return e.t4_ns >= e.t1_ns && e.t3_ns >= e.t2_ns && delay_ns(e) >= 0;
}

// Exchanges by t1, parted where the agent's clock was set, or its machine restarted: whatever the delays, the
// agent's clock is ahead of the host's by t3 - t4 at least and t2 - t1 at most, so exchanges whose spans do
// not meet belong to different settings of the clock. Three in a row make a new one; fewer contradict the
// rest and are left out.
struct ExchangeSegments {
  std::vector<std::vector<ClockExchange>> segments;
  std::size_t backwards = 0;
  std::size_t contradicting = 0;
};
ExchangeSegments split_exchanges(std::span<const ClockExchange> exchanges);

// A clock's offset from a straight line, by the median of the least delayed exchanges of some seconds.
struct WanderWindow {
  std::int64_t host_ns = 0;  // middle of those exchanges
  double residual_ns = 0.0;
  double sigma_ns = 0.0;  // standard deviation of the residual
  std::size_t exchanges = 0;
};

// Of windows of 10 s, longer where these hold fewer than twelve exchanges, which are ordered by t1. Exchanges
// with more than twice `usual_delay_ns` are left out, and windows that keep fewer than three.
std::vector<WanderWindow> wander_windows(const std::vector<ClockExchange>& exchanges, std::int64_t base_ns,
                                         const OffsetLine& line, std::int64_t usual_delay_ns);

// Whether no two neighbouring windows leave the line to the same side by more than 0.3 ms or, if that is
// more, four standard deviations: one alone is more likely a disturbance of the network.
bool is_straight(const std::vector<WanderWindow>& windows);

}  // namespace trilat
