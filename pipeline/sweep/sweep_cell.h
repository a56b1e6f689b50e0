// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "evaluators/solvers/range_lanes.h"
#include "evaluators/solvers/range_problem.h"
#include "pipeline/sweep/sweep_spec.h"
#include "pipeline/sweep/sweep_summary.h"

namespace trilat {

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
  double mean() const;  // NaN of none

 private:
  std::vector<std::uint64_t> counts_;
};

// Distances fall into bins of 1/64 of an octave.
inline constexpr std::size_t kDistanceBins = 64 * 64;
std::size_t distance_bin(double distance_m);
double bin_distance_m(std::size_t bin);  // its middle

// Sums over trials, in their order.
struct SweepSums {
  std::uint64_t asked = 0, answered = 0;
  std::uint64_t starts = 0;  // that are finite
  std::array<std::uint64_t, kSolveStatusCount> statuses{};
  double start_m = 0.0;  // distances of the starts from the true joints
  double distance_m = 0.0, square_m2 = 0.0, max_m = 0.0;
  std::array<double, 3> axis_m{};
  Counts distance_bins, iterations;

  void add_start(const Eigen::Vector3d& from_m, const Eigen::Vector3d& truth_m);
  void add(const Eigen::Vector3d& position_m, SolveStatus status, std::size_t steps,
           const Eigen::Vector3d& truth_m);
  void add(const SweepSums& later);
};
// The numbers of a cell, as SweepSummary has them, by Student's t over the answered trials; quantiles of the
// distance to within 0.8 %.
Numbers numbers_of(const SweepSums& sums, const NumberKey& cell);

// Linear trilateration of a rig that does not move: its equations hold the squared ranges on the right side
// only, so the least-squares answer is x = offset + factor * r^2.
struct LinearStart {
  std::array<double, 3> offset_m{};
  std::array<std::array<double, kMaxSensors>, 3> factor_per_m{};

  // Columns of `range_m` (a row a sensor) to columns of `position_m`.
  void positions(int sensors, std::size_t count, const AlignedRows& range_m, AlignedRows& position_m) const;
};

// The sensors of `problem`, the first of which is the reference, as in solve_linear() by default. They must
// be four or more and not in one plane.
LinearStart linear_start(const RangeProblem& problem);

inline constexpr std::size_t kBlockTrials = 512;

// Trials of one cell, a block at a time; used by one thread at a time. They end as solve_nonlinear() ends.
class SweepBlock {
 public:
  explicit SweepBlock(const SweepTrials& cell);

  // Makes `count` <= kBlockTrials trials.
  void make_trials(std::uint64_t first_trial, std::size_t count);
  // The trials as problems, valid until the next ones are made.
  std::span<const RangeProblem> problems();
  // Solves them and adds starts and outcomes.
  void solve_into(SweepSums& sums);

 private:
  void find_starts();
  void solve();
  bool is_far_off(std::size_t trial) const;

  SweepTrials cell_;
  bool by_lanes_ = false;  // otherwise one by one
  bool is_thick_ = false;
  std::optional<LinearStart> linear_;
  RangeLanes lanes_;
  AlignedRows truth_m_, mean_m_;
  std::vector<RangeProblem> problems_;
  std::size_t problems_made_ = 0;
};

}  // namespace trilat
