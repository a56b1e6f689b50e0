// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "datasets/base/described.h"
#include "datasets/base/strict_json.h"
#include "datasets/results/results_file.h"

namespace trilat {

// The paper's ranges of Table IV: each from its edge to the next, the last without an end. A duration below
// 11 ms that is no clock error falls into one of the first three, which the paper counts as (0, 11).
inline constexpr std::array<double, 6> kTimeEdges_s{0.0, 0.002, 0.004, 0.011, 0.022, 0.033};

// How durations, or absolute errors of clocks, are spread. NaN without any.
struct TimeSpread {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::uint64_t n = 0;
  std::array<std::uint64_t, kTimeEdges_s.size()> bins{};
  double median_s = kNone, p95_s = kNone, p99_s = kNone, p999_s = kNone, max_s = kNone;

  TRILAT_FIELDS(n, bins, median_s, p95_s, p99_s, p999_s, max_s)
};

// What differs from machine to machine and run to run.
struct SweepTimings {
  static constexpr const char *kFile = "timings.json", *kFormat = "trilat.timings";
  std::string study;
  std::string processor;
  // Problems of each cell that the scalar solver solved on one thread, the fastest of three times; 0: all
  // trials, made and solved as the run took them.
  std::uint64_t problems = 0;
  std::vector<double> solve_us;  // a solve, start included; of each cell of the summary, in its order

  TRILAT_FIELDS(study, processor, problems, solve_us)
};

}  // namespace trilat
