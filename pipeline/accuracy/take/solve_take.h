// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "datasets/results/stored_take.h"
#include "pipeline/accuracy/methods/over_time.h"
#include "pipeline/accuracy/take/plan.h"
#include "pipeline/accuracy/take/take_data.h"
#include "pipeline/accuracy/take/take_result.h"
#include "pipeline/study/watch.h"

namespace trilat {

// Where the time of a run went, in nanoseconds summed over threads.
struct StageClocks {
  std::atomic<std::int64_t> read_ns{0}, solve_ns{0}, write_ns{0}, summarise_ns{0};
};

// Adds the life of this object to a clock.
class Stopwatch {
 public:
  explicit Stopwatch(std::atomic<std::int64_t>& total_ns) : total_ns_(total_ns) {}
  ~Stopwatch() { total_ns_ += static_cast<std::int64_t>(1e9 * time_.seconds()); }

 private:
  std::atomic<std::int64_t>& total_ns_;
  RunningTime time_;
};

// The methods that are compared with Ceres: all nonlinear and newton ones with damping lm, the step rule and
// squares, with the stated calibration.
std::vector<const Method*> checked_methods(const Plan& plan);

// Sends every instant of a take through every method, on the threads of the current arena, and gives away
// block by block in the order of time. `brought`: paths of the methods that are not solved here. The result
// is how Ceres compares, by checked method, where that is asked for. Throws Interrupted when asked to stop.
std::vector<TakeCheck> solve_take(const Plan& plan, const PlannedTake& planned, const TakeData& data,
                                  std::span<const MethodPaths> brought, bool cross_check, StageClocks& clocks,
                                  const Watch& watch, const std::function<void(const SampleBlock&)>& each);

}  // namespace trilat
