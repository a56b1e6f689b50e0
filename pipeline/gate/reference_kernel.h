// SPDX-License-Identifier: MIT
#pragma once

#include <span>

namespace trilat {

// What all speeds are multiples of. It must never change, or no ratio of one night means anything beside
// those of another; whoever must change it gives it another name.
inline constexpr const char* kReferenceKernel = "plain Gauss-Newton, version 1";

struct ReferenceProblem {
  double sensor_m[4][3];
  double range_m[4];
};

// Six steps of textbook Gauss-Newton from the middle of four sensors, normal equations by Cramer's rule: the
// operations that solvers spend their time with, and nothing from any library. The sum of the positions
// found, so that nothing can be left out.
double solve_reference(std::span<const ReferenceProblem> problems);

}  // namespace trilat
