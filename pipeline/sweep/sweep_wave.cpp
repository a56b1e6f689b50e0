// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_wave.h"

#include <algorithm>
#include <atomic>
#include <chrono>

#include <tbb/task_arena.h>

#include "pipeline/parallel.h"
#include "pipeline/sweep/sweep_runner.h"

namespace trilat {
namespace {

using Clock = std::chrono::steady_clock;

// At the end of a wave some threads wait for the last chunk: there should be many chunks a thread. But
// nothing is saved within a wave.
constexpr std::size_t kLeastChunksPerThread = 8;
constexpr std::size_t kMostChunks = 64;
constexpr std::chrono::milliseconds kSoon{500};
constexpr std::chrono::seconds kLate{5};

}  // namespace

SweepWave::SweepWave(const SweepPlan& plan, const std::function<bool()>& stop_requested)
    : plan_(plan),
      stop_requested_(stop_requested),
      least_(kLeastChunksPerThread * static_cast<std::size_t>(tbb::this_task_arena::max_concurrency())),
      size_(least_) {}

void SweepWave::add(std::size_t cell, std::uint64_t first_trial) {
  if (count_ == chunks_.size()) chunks_.emplace_back();
  chunks_[count_].cell = cell;
  chunks_[count_].first_trial = first_trial;
  ++count_;
}

void SweepWave::compute(const std::function<void()>& chunk_done) {
  const Clock::time_point start = Clock::now();
  std::atomic<std::size_t> next{0};
  parallel_for_index(count_, 1, [&](std::size_t) {
    compute(chunks_[next.fetch_add(1)]);
    chunk_done();
  });
  const auto took = Clock::now() - start;
  if (took < kSoon) size_ = std::max(least_, std::min(2 * size_, kMostChunks));
  if (took > kLate) size_ = std::max(least_, size_ / 2);
}

void SweepWave::compute(Chunk& chunk) {
  chunk.done = false;
  chunk.sums.clear();
  if (stop()) return;
  const std::uint64_t end_trial =
      std::min<std::uint64_t>(chunk.first_trial + kChunkTrials, plan_.spec.trials);
  const SweepCellSolver solver = solver_of(plan_, place_of(plan_, chunk.cell));
  std::unique_ptr<SweepBlock> block = blocks_.take(solver.trials.sensors);
  chunk.done = true;
  for (std::uint64_t trial = chunk.first_trial; trial < end_trial && chunk.done; trial += kBlockTrials) {
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(kBlockTrials, end_trial - trial));
    block->make_trials(solver, trial, count);
    block->solve_into(solver, chunk.sums);
    if (trial < plan_.spec.digits_trials)
      block->add_digits(solver, static_cast<std::size_t>(plan_.spec.digits_trials - trial), chunk.sums);
    chunk.done = !stop();
  }
  blocks_.give_back(std::move(block));
}

}  // namespace trilat
