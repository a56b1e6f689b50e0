// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "datasets/results/studies/sweep_summary.h"
#include "evaluators/solvers/point_estimate.h"

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

// Distances fall into bins of 1/64 of an octave, digits into bins of 1/256.
inline constexpr std::size_t kDistanceBins = 64 * 64;
std::size_t distance_bin(double distance_m);
double bin_distance_m(std::size_t bin);  // its middle
inline constexpr double kMostDigits = 15.0;
inline constexpr std::size_t kDigitBins = 15 * 256 + 1;
std::size_t digit_bin(double digits);
double bin_digits(std::size_t bin);  // its middle

// What is counted of trials: the same in whatever order and groups they are added.
struct SweepCounts {
  std::uint64_t asked = 0;
  std::array<std::uint64_t, kSolveStatusCount> statuses{};
  std::uint64_t starts = 0;  // that are finite
  double max_m = 0.0;
  double min_digits = kMostDigits;
  Counts distance_bins, iteration_counts, digit_bins;

  void add(const SweepCounts& other);
};

// Over trials, in their order.
struct SweepSums {
  enum Term { x, y, z, distance, square, start, iterations, digits, kTerms };
  SweepCounts counts;
  std::array<double, kTerms> sum{};

  void add_starts(const SweepOutcomeRows& rows);  // position_m: the starts
  void add_outcomes(const SweepOutcomeRows& rows);
  void add_digits(double digits);  // of one trial
  void add(const SweepSums& later);
};
// Everything but the cell's place.
SweepCell cell_of(const SweepSums& sums);

}  // namespace trilat
