// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

namespace trilat {

// The quantile of Student's t for two-sided intervals of level 1 - alpha. 0 degrees of freedom are the
// caller's error.
double student_quantile(std::size_t degrees, double alpha = 0.05);

// The probability that Student's t of so many degrees of freedom is at least as far from 0 as `t`, on either
// side. 1 for t = 0, 0 for infinite t, NaN for NaN or no degrees.
double student_two_sided(double t, std::size_t degrees);

}  // namespace trilat
