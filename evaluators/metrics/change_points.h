// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace trilat {

struct ChangePointOptions {
  // What one more change must save: penalty * sigma^2 * log(n), beside the squared residuals. 2 is BIC's;
  // more finds less.
  double penalty = 4.0;
  std::size_t shortest = 1;    // values a stretch has at least; 2 passes over single strays
  double least_sigma = 1e-12;  // noise is not taken for less, in units of the values
};

// A stretch of values around one level.
struct Stretch {
  std::size_t first = 0, end = 0;  // [first, end)
  double level = 0.0;              // mean
};

struct Segmentation {
  std::vector<Stretch> stretches;  // in order; empty without values
  double sigma = 0.0;              // noise around the levels
};

// Cuts a series where its level changes: the segmentation with the least squared residuals plus penalties, by
// dynamic programming (Auger and Lawrence 1989; Killick, Fearnhead and Eckley 2012). The noise is estimated
// around the levels and not around one mean, so that a change does not hide the next: first from differences
// of neighbours (median absolute, which changes hardly move), then from the residuals of the segmentation
// found. Values are finite (InternalError).
[[nodiscard]] Segmentation find_change_points(std::span<const double> values,
                                              const ChangePointOptions& options);

}  // namespace trilat
