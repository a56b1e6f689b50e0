// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include "datasets/results/replay.h"
#include "datasets/results/samples.h"
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

// Sends one take through every method into `folder`: samples.h5, and replay.h5 when it is replayed. Throws
// Interrupted when asked to stop.
EvaluatedTake evaluate_take(const Plan& plan, std::size_t take, bool cross_check,
                            const std::filesystem::path& folder, StageClocks& clocks, const Watch& watch);

// Whether this is the first take of its condition that can be evaluated, as far as the plan knows.
bool is_replayed(const Plan& plan, std::size_t take);

// The first part of a take as every sensor sees it, in the world.
ReplayTake replay_of(const Plan& plan, const PlannedTake& planned, const TakeData& data);

}  // namespace trilat
