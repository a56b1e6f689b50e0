// SPDX-License-Identifier: MIT
#pragma once

#include <span>

namespace trilat {

// What all speeds are multiples of. It must never change, or no ratio of one night means anything beside
// those of another; whoever must change it gives it another name.
inline constexpr const char* kReferenceKernel = "plain Gauss-Newton, eight side by side, version 1";

struct ReferenceProblem {
  double sensor_m[4][3];
  double range_m[4];
};

// Six steps of textbook Gauss-Newton from the middle of four sensors, normal equations by Cramer's rule, for
// eight problems side by side: the operations that solvers spend their time with, and nothing from any
// library. Side by side because such work waits for the processor's units and not for its own results: what
// else runs on the same core slows it down as much as it does solvers. The sum of the positions found, so
// that nothing can be left out; what is beyond a multiple of eight problems is not solved.
double solve_reference(std::span<const ReferenceProblem> problems);

}  // namespace trilat
