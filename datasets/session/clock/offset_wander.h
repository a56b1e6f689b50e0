// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "datasets/session/clock/offset_samples.h"
#include "datasets/session/session_types.h"

namespace trilat {

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
