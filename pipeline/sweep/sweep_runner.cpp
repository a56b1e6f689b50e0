// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_runner.h"

#include <algorithm>
#include <atomic>

#include "pipeline/parallel.h"
#include "pipeline/sweep/sweep_block.h"

namespace trilat {
namespace {

constexpr std::size_t kWave = 64;  // chunks that are computed side by side and then added up in order

// Where a chunk goes until its turn to be added.
struct Slot {
  SweepSums sums;
  bool done = false;
};

class Runner {
 public:
  Runner(const SweepPlan& plan, const SweepRunOptions& options)
      : plan_(plan),
        options_(options),
        chunks_per_cell_((plan.spec.trials + kChunkTrials - 1) / kChunkTrials),
        slots_(kWave) {}

  SweepRun run() {
    SweepRun result;
    result.cells.resize(plan_.cells());
    const std::uint64_t chunks = plan_.cells() * chunks_per_cell_;
    for (std::uint64_t first = 0; first < chunks && !result.interrupted; first += kWave) {
      const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(kWave, chunks - first));
      parallel_for_index(count, 1, [&](std::size_t i) { compute(first + i, slots_[i]); });
      for (std::size_t i = 0; i < count; ++i) add_in_order(first + i, slots_[i], result);
    }
    for (std::size_t c = 0; c < result.cells.size(); ++c) {
      const SweepCellPlace place = place_of(plan_, c);
      result.cells[c].interpretation = place.reading;
      result.cells[c].threshold = place.threshold;
      result.cells[c].range = place.range;
    }
    return result;
  }

 private:
  bool stop() const { return options_.stop_requested && options_.stop_requested(); }

  void compute(std::uint64_t chunk, Slot& slot) {
    slot.done = false;
    slot.sums.clear();
    if (stop()) return;
    const std::size_t cell = chunk / chunks_per_cell_;
    const std::uint64_t first_trial = chunk % chunks_per_cell_ * kChunkTrials;
    const std::uint64_t end_trial = std::min(first_trial + kChunkTrials, plan_.spec.trials);
    const SweepCellSolver solver = solver_of(plan_, place_of(plan_, cell));
    std::unique_ptr<SweepBlock> block = blocks_.take(solver.trials.sensors);
    slot.done = true;
    for (std::uint64_t trial = first_trial; trial < end_trial && slot.done; trial += kBlockTrials) {
      const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(kBlockTrials, end_trial - trial));
      block->make_trials(solver, trial, count);
      block->solve_into(solver, slot.sums);
      if (trial < plan_.spec.digits_trials)
        block->add_digits(solver, static_cast<std::size_t>(plan_.spec.digits_trials - trial), slot.sums);
      slot.done = !stop();
    }
    blocks_.give_back(std::move(block));
    const std::uint64_t done = ++chunks_done_;
    if (options_.progress)
      options_.progress(static_cast<double>(done) / static_cast<double>(plan_.cells() * chunks_per_cell_));
  }

  // Chunks of one cell follow each other, so only one cell is open at a time.
  void add_in_order(std::uint64_t chunk, const Slot& slot, SweepRun& result) {
    const std::size_t cell = chunk / chunks_per_cell_;
    if (chunk % chunks_per_cell_ == 0) open_cell_.clear();
    if (slot.done)
      open_cell_.add(slot.sums);
    else
      result.interrupted = true;
    if (result.interrupted || (chunk + 1) % chunks_per_cell_ == 0) result.cells[cell] = open_cell_.cell();
  }

  const SweepPlan& plan_;
  const SweepRunOptions& options_;
  const std::uint64_t chunks_per_cell_;
  std::vector<Slot> slots_;
  SweepBlocks blocks_;
  SweepSums open_cell_;
  std::atomic<std::uint64_t> chunks_done_{0};
};

}  // namespace

SweepRun run_sweep(const SweepPlan& plan, const SweepRunOptions& options) {
  return Runner(plan, options).run();
}

}  // namespace trilat
