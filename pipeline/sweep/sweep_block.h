// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "evaluators/solvers/point_estimate.h"
#include "evaluators/solvers/range_problem.h"
#include "pipeline/sweep/sweep_spec.h"
#include "pipeline/sweep/sweep_summary.h"

namespace trilat {

// How a block of trials ended: a column a trial, rows `stride` apart.
struct SweepOutcomeRows {
  std::size_t count = 0;
  std::size_t stride = 0;
  const double* truth_m = nullptr;     // 3 rows
  const double* position_m = nullptr;  // 3 rows
  const double* iterations = nullptr;
  const SolveStatus* status = nullptr;
};

// How often each value came.
class Counts {
 public:
  void add(std::size_t value, std::uint64_t times = 1) {
    if (value >= counts_.size()) counts_.resize(value + 1);
    counts_[value] += times;
  }
  void add(const Counts& other) {
    for (std::size_t i = 0; i < other.counts_.size(); ++i)
      if (other.counts_[i] > 0) add(i, other.counts_[i]);
  }
  // The smallest value that is not exceeded by this share of all; 0 of none.
  std::size_t quantile(double share) const;
  std::uint64_t all() const;

 private:
  std::vector<std::uint64_t> counts_;
};

// Distances fall into bins of 1/64 of an octave.
inline constexpr std::size_t kDistanceBins = 64 * 64;
std::size_t distance_bin(double distance_m);
double bin_distance_m(std::size_t bin);  // its middle

// Counts of trials: the same in whatever order and groups they are added.
struct SweepCounts {
  std::uint64_t asked = 0;
  std::array<std::uint64_t, kSolveStatusCount> statuses{};
  std::uint64_t starts = 0;  // that are finite
  double max_m = 0.0;
  Counts distance_bins, iteration_counts;

  void add(const SweepCounts& other);
};

// Over trials, in their order.
struct SweepSums {
  enum Term { x, y, z, distance, square, start, iterations, kTerms };
  SweepCounts counts;
  std::array<double, kTerms> sum{};

  void add_starts(const SweepOutcomeRows& rows);  // position_m: the starts
  void add_outcomes(const SweepOutcomeRows& rows);
  void add(const SweepSums& later);
};
// Everything but the cell's setting.
SweepCell cell_of(const SweepSums& sums);

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

// The trials of one cell, and by what they are solved.
struct SweepCellSolver : SweepTrials {
  // One undamped descent straight from the rows of trials; otherwise solve_nonlinear() one by one.
  bool straight = false;
  LinearStart linear;  // when straight and so started
};
SweepCellSolver solver_of(const SweepTrials& trials);

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

 private:
  void find_starts(const SweepCellSolver& cell);
  void descend_in_stages(const DescentOptions& options);
  void refuse_far_answers(const SweepCellSolver& cell);
  void solve_one_by_one(const SweepCellSolver& cell);
  SweepOutcomeRows rows() const;

  DescentBatch batch_, unfinished_;
  std::vector<std::size_t> unfinished_lanes_;
  LaneRows truth_m_, mean_m_;
  std::vector<RangeProblem> problems_;
  std::vector<PointEstimate> estimates_;
  bool problems_are_made_ = false;
};

}  // namespace trilat
