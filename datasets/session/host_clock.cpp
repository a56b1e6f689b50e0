// SPDX-License-Identifier: MIT
#include "datasets/session/host_clock.h"

#ifdef _WIN32
#include <windows.h>
#else
#include <ctime>
#endif

namespace trilat {

std::int64_t host_now_ns() {
#ifdef _WIN32
  LARGE_INTEGER ticks, per_s;
  ::QueryPerformanceCounter(&ticks);
  ::QueryPerformanceFrequency(&per_s);
  const std::int64_t seconds = ticks.QuadPart / per_s.QuadPart, rest = ticks.QuadPart % per_s.QuadPart;
  return seconds * 1'000'000'000 + rest * 1'000'000'000 / per_s.QuadPart;
#else
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC_RAW, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
#endif
}

}  // namespace trilat
