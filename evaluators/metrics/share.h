// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include "evaluators/solvers/point_estimate.h"

namespace trilat {

// A share, with its exact 95 % interval by Clopper and Pearson 1934: never below 0 nor above 1, and never of
// no width.
struct ShareEstimate {
  double value = kNaN, low = kNaN, high = kNaN;
  double successes = kNaN, trials = kNaN;  // what the interval is made from; of clusters not whole
  std::size_t clusters = 0;                // with samples

  // The probability of so many successes or more (or fewer) if the true share were `share`; 1 where nothing
  // is known.
  double chance_of_more(double share) const;
  double chance_of_fewer(double share) const;
};

// Of independent trials; each is a cluster.
ShareEstimate estimate_share(double successes, double trials);

// Of samples that hang together within clusters: of as many independent trials as give the standard error
// between clusters (Korn and Graubard, Survey Methodology 24, 1998). Where all clusters have the same share,
// nothing is known of that error, and each counts as one trial. NaN bounds for fewer than two clusters.
ShareEstimate estimate_share(const std::vector<double>& successes, const std::vector<double>& samples);

}  // namespace trilat
