// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "datasets/results/sweep_summary.h"
#include "evaluators/solvers/solve_status.h"

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

// How often each value came. Distances fall into bins of 1/64 of an octave.
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
  void clear() { counts_.clear(); }
  // The smallest value that is not exceeded by this share of all; 0 of none.
  std::size_t quantile(double share) const;

 private:
  std::vector<std::uint64_t> counts_;
};
std::size_t distance_bin(double distance_m);
double bin_distance_m(std::size_t bin);  // its middle

// Sums over trials, of a chunk or of a whole cell. Chunks are added in their order, with the rounding errors
// carried along (Neumaier), so that a billion trials lose nothing.
struct SweepSums {
  enum Term { x, y, z, distance, square, start, iterations, kTerms };
  std::array<double, kTerms> sum{}, lost{};
  std::uint64_t asked = 0;
  std::array<std::uint64_t, kSolveStatusCount> statuses{};
  std::uint64_t starts = 0;
  double max_m = 0.0;
  Counts distance_bins, iteration_counts;
  std::vector<double> digits;

  void clear();
  void add_starts(const SweepOutcomeRows& rows);  // position_m: the starts
  void add_outcomes(const SweepOutcomeRows& rows);
  void add(const SweepSums& later);
  // Everything but the cell's place.
  SweepCell cell() const;
};

}  // namespace trilat
