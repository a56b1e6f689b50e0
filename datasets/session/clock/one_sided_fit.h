// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "datasets/session/clock/offset_samples.h"
#include "datasets/session/clock/offset_wander.h"

namespace trilat {

// Which way of the exchanges is delayed evenly where the other queues: medians of midpoints then follow the
// queue, while the least delays of both ways stay where they are.
enum class SteadyWay { both, to_agent, to_host };

// By the delays of each way above the least, against a line through the midpoints: one way is steady where
// the other's median is beyond 0.3 ms and three times its own.
SteadyWay steady_way(const std::vector<ClockExchange>& exchanges, std::int64_t base_ns,
                     const OffsetLine& line);

// A line midway between the least delays of both ways, along the steady one.
struct OneSidedFit {
  OffsetLine line;
  double sigma_ns = 0.0;
  double slope_sigma = 0.0;
  std::vector<WanderWindow> windows;  // of the steady way, from the line
};
// `slope` is kept where it is known better than these exchanges tell it.
enum class SlopeOf { line, exchanges };
OneSidedFit fit_one_sided(const std::vector<ClockExchange>& exchanges, std::int64_t base_ns,
                          const OffsetLine& line, SteadyWay steady, SlopeOf slope);

}  // namespace trilat
