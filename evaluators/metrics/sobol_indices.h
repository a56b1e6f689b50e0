// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "evaluators/solvers/point_estimate.h"

namespace trilat {

// A number with its 95 % interval; NaN where there is none.
struct WithInterval {
  double value = kNaN, low = kNaN, high = kNaN;
};

inline constexpr std::size_t kMostFactors = 20;

// A design for variance-based sensitivity analysis in the unit cube (Saltelli 2002): rows of `factors` + 2
// points. Points A and B of a row are the halves of a point of a Sobol sequence of twice the dimension, the
// others are A with one coordinate of B each. At most kMostFactors factors; points[row * (factors + 2) +
// column], each of `factors` coordinates in (0, 1).
std::vector<std::vector<double>> saltelli_design(std::size_t factors, std::size_t rows);

// What share of a quantity's variance a factor explains by itself, and with all its interactions.
struct SobolIndices {
  WithInterval first, total;
};

// By the estimators of Saltelli et al. 2010 (table 2, first index) and Jansen 1999 (total index). `values`:
// of the design's points; a row with a value that is not finite is left out of all that need it. Intervals
// are percentiles of a bootstrap of rows.
std::vector<SobolIndices> sobol_indices(std::span<const double> values, std::size_t factors,
                                        std::size_t resamples, std::uint64_t seed);

// Statistics of rows, with percentile intervals of a bootstrap of rows: `statistics` gets the numbers of rows
// (with repetitions) and gives as many numbers every time. One that is not finite in more than 1 of 20
// resamples has no interval.
std::vector<WithInterval> bootstrap_rows(
    std::size_t rows, std::size_t resamples, std::uint64_t seed,
    const std::function<std::vector<double>(std::span<const std::size_t>)>& statistics);

// Where the straight line that fits the points (x, y) best crosses 0, taken to the nearer end where that is
// not within [0, 1]; NaN for a level line and without points.
double crossing_of_line(std::span<const double> x, std::span<const double> y);

}  // namespace trilat
