// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>

namespace trilat {

// This machine's monotonic clock, which stamps arrivals and clock exchanges.
inline std::int64_t steady_now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace trilat
