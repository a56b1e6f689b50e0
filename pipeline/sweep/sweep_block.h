// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "evaluators/solvers/range_problem.h"
#include "pipeline/sweep/sweep_plan.h"
#include "pipeline/sweep/sweep_sums.h"

namespace trilat {

// Linear trilateration of a rig that does not move: its equations hold the squared ranges on the right side
// only, so the least-squares answer is x = offset + factor * r^2.
struct LinearStart {
  std::array<double, 3> offset_m{};
  std::array<std::array<double, kMaxSensors>, 3> factor_per_m{};

  // Columns of `range_m` (a row a sensor) to columns of `position_m` (3 rows).
  void positions(int sensors, std::size_t count, std::size_t stride, const double* range_m,
                 double* position_m) const;
};

// The sensors of `problem`, the first of which is the reference, as in solve_linear() by default. They must
// be four or more and not in one plane.
LinearStart linear_start(const RangeProblem& problem);

inline constexpr std::size_t kBlockTrials = 512;

// The trials of one cell: how they are made, started and solved.
struct SweepCellSolver {
  RangeTrialModel trials;
  NonlinearOptions options;
  SweepStart start = SweepStart::linear;
  bool hint_is_mean = false, hint_is_previous = false;
  SensorPlane plane;
  RangeProblem sensors;  // without ranges
  // One undamped descent straight from the rows of trials; otherwise solve_nonlinear() one by one.
  bool straight = false;
  LinearStart linear;  // when straight and so started
};
SweepCellSolver solver_of(const SweepPlan& plan, const SweepCellPlace& place);

// Room for a block of trials with so many sensors; one is used by one thread at a time.
class SweepBlock {
 public:
  explicit SweepBlock(int sensors);
  int sensors() const { return batch_.sensors; }

  // Makes `count` <= kBlockTrials trials.
  void make_trials(const SweepCellSolver& cell, std::uint64_t first_trial, std::size_t count);
  // The trials as problems, valid until the next ones are made.
  std::span<const RangeProblem> problems(const SweepCellSolver& cell);
  // Solves them and adds starts and outcomes.
  void solve_into(const SweepCellSolver& cell, SweepSums& sums);
  // Adds the digits to which the answers of the first `count` trials agree with the exact minimum.
  void add_digits(const SweepCellSolver& cell, std::size_t count, SweepSums& sums);

 private:
  void find_starts(const SweepCellSolver& cell);
  void descend_in_stages(const DescentOptions& options);
  void refuse_far_answers(const SweepCellSolver& cell);
  void solve_one_by_one(const SweepCellSolver& cell);
  SweepOutcomeRows rows() const;

  DescentBatch batch_, unfinished_;
  std::vector<std::size_t> unfinished_lanes_;
  LaneRows truth_m_, mean_m_, previous_m_;
  std::vector<RangeProblem> problems_;
  std::vector<PointEstimate> estimates_;
  bool problems_are_made_ = false;
};

// Blocks for as many threads as there are, handed out again while they are warm.
class SweepBlocks {
 public:
  std::unique_ptr<SweepBlock> take(int sensors);
  void give_back(std::unique_ptr<SweepBlock> block);

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<SweepBlock>> blocks_;
};

}  // namespace trilat
