// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_timing.h"

#include <algorithm>
#include <chrono>

#include "pipeline/study/results_folder.h"
#include "pipeline/sweep/sweep_block.h"

namespace trilat {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kWarmUpProblems = 64;

double ns_since(Clock::time_point start) {
  return std::chrono::duration<double, std::nano>(Clock::now() - start).count();
}

// Nanoseconds a solve, of all problems of a cell.
struct Round {
  double scalar_ns = 0.0, batched_ns = 0.0;
};

class Stopwatch {
 public:
  Stopwatch(const SweepPlan& plan, const std::function<bool()>& stop_requested)
      : plan_(plan), stop_requested_(stop_requested) {}

  bool stopped() const { return stop_requested_ && stop_requested_(); }

  Round time(std::size_t cell, std::uint64_t problems) {
    const SweepCellSolver solver = solver_of(plan_, place_of(plan_, cell));
    const std::unique_ptr<SweepBlock> block = blocks_.take(solver.trials.sensors);
    Round round;
    for (std::uint64_t first = 0; first < problems && !stopped(); first += kBlockTrials) {
      block->make_trials(solver, first,
                         static_cast<std::size_t>(std::min<std::uint64_t>(kBlockTrials, problems - first)));
      const auto all = block->problems(solver);
      estimates_.resize(all.size());
      round.scalar_ns += scalar_ns(all, solver.options);
      const auto start = Clock::now();
      solve_nonlinear(all, solver.options, estimates_);
      round.batched_ns += ns_since(start);
    }
    round.scalar_ns /= static_cast<double>(problems);
    round.batched_ns /= static_cast<double>(problems);
    return round;
  }

 private:
  double scalar_ns(std::span<const RangeProblem> problems, const NonlinearOptions& options) {
    const auto start = Clock::now();
    for (std::size_t i = 0; i < problems.size(); ++i) estimates_[i] = solve_nonlinear(problems[i], options);
    return ns_since(start);
  }

  const SweepPlan& plan_;
  const std::function<bool()>& stop_requested_;
  SweepBlocks blocks_;
  std::vector<PointEstimate> estimates_;
};

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

SweepCellTiming timing_of(const SweepCellPlace& place, const std::vector<Round>& rounds) {
  std::vector<double> scalar_ns, batched_ns;
  for (const Round& round : rounds) {
    scalar_ns.push_back(round.scalar_ns);
    batched_ns.push_back(round.batched_ns);
  }
  return {place.reading,
          place.threshold,
          place.range,
          median(scalar_ns),
          *std::min_element(scalar_ns.begin(), scalar_ns.end()),
          median(batched_ns),
          *std::min_element(batched_ns.begin(), batched_ns.end())};
}

}  // namespace

std::optional<SweepTimings> time_sweep(const SweepPlan& plan, const std::function<bool()>& stop_requested,
                                       const std::function<void(double)>& progress) {
  const std::uint64_t problems = plan.spec.time_problems;
  if (progress) progress(0.0);
  Stopwatch stopwatch(plan, stop_requested);
  std::vector<std::vector<Round>> rounds(plan.cells());
  for (std::size_t cell = 0; cell < plan.cells(); ++cell)
    stopwatch.time(cell, std::min<std::uint64_t>(kWarmUpProblems, problems));
  for (std::uint64_t repeat = 0; repeat < plan.spec.time_repeats; ++repeat) {
    for (std::size_t cell = 0; cell < plan.cells(); ++cell) {
      rounds[cell].push_back(stopwatch.time(cell, problems));
      if (stopwatch.stopped()) return std::nullopt;
    }
    if (progress) progress(static_cast<double>(repeat + 1) / static_cast<double>(plan.spec.time_repeats));
  }
  SweepTimings timings{plan.spec.name, processor_name(), problems, plan.spec.time_repeats, {}};
  for (std::size_t cell = 0; cell < plan.cells(); ++cell)
    timings.cells.push_back(timing_of(place_of(plan, cell), rounds[cell]));
  return timings;
}

}  // namespace trilat
