// SPDX-License-Identifier: MIT
// Monte-Carlo tests run a twentieth of their trials, and all of them with TRILAT_ALL_TRIALS=1, as
// `scripts/check_all statistics` sets it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>

namespace trilat {

inline bool runs_all_trials() { return std::getenv("TRILAT_ALL_TRIALS") != nullptr; }

inline std::uint64_t trials(std::uint64_t all) {
  return runs_all_trials() ? all : std::max<std::uint64_t>(all / 20, 2);
}

// Margin of a limit on a share: four standard errors of `count` trials; 0 when all trials run.
inline double slack(double limit, std::uint64_t count) {
  return runs_all_trials() ? 0.0 : 4.0 * std::sqrt(limit * (1.0 - limit) / static_cast<double>(count));
}

}  // namespace trilat
