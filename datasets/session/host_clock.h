// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace trilat {

// Nanoseconds of this machine's monotonic clock, which nothing slews towards other clocks
// (CLOCK_MONOTONIC_RAW, on Windows the performance counter). It stamps arrivals and clock exchanges, and
// begins anew when the machine is started.
std::int64_t host_now_ns();

}  // namespace trilat
