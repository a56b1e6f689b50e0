// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>

#include "evaluators/solvers/point_estimate.h"

namespace trilat {

// Differences of one person: how many, their sum and the sum of their squares.
struct DifferenceSums {
  double n = 0.0, sum = 0.0, sum2 = 0.0;
};

// How far one measurement is from another, in their unit: the mean difference, and the limits within which 95
// % of single differences lie, each with its 95 % interval. NaN where it cannot be known.
struct Agreement {
  double bias = kNaN, bias_low = kNaN, bias_high = kNaN;
  double sd = kNaN;  // of a single difference, of any person
  double lower = kNaN, lower_low = kNaN, lower_high = kNaN;
  double upper = kNaN, upper_low = kNaN, upper_high = kNaN;
  std::size_t persons = 0;
};

// Bland and Altman, "Measuring agreement in method comparison studies", 1999, section 5.3: several
// measurements of each person, whose true value varies. The variance of a single difference is that within
// persons and that between them, by one-way analysis of variance; limits are bias -+ 1.96 sd. Intervals are
// Student's t with persons - 1 degrees of freedom, the standard error of a limit being that of the bias and,
// beside it, 1.96 times that of sd by Satterthwaite's degrees of freedom. Of a single person there are the
// bias and, from within, the limits, without intervals. NaN without differences.
Agreement limits_of_agreement(std::span<const DifferenceSums> persons);

}  // namespace trilat
