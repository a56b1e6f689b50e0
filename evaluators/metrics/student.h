// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace trilat {

// Probabilities of chance, corrected for how many are looked at (Holm 1979): rejecting what comes out at or
// below alpha makes one false rejection or more with probability alpha at most, however they depend on each
// other. NaN is no test: it stays NaN and counts for none.
std::vector<double> holm_adjusted(std::span<const double> p);

// The quantile of Student's t for two-sided intervals of level 1 - alpha; NaN for 0 degrees of
// freedom.
double student_quantile(std::size_t degrees, double alpha = 0.05);

// The probability that Student's t of so many degrees of freedom is at least as far from 0 as `t`, on either
// side. 1 for t = 0, 0 for infinite t, NaN for NaN or no degrees.
double student_two_sided(double t, std::size_t degrees);

// The squared length, in variances of one axis, that a normal vector of so many dimensions exceeds as rarely
// as a normal number exceeds `sigmas` standard deviations on either side: the quantile of chi-square. Beyond
// 37 standard deviations the probability underflows, and the limit is the square of `sigmas`.
double chi_square_limit(double sigmas, double dimensions);

// The quantile of the gamma distribution: what is not exceeded with probability `p`. Shape and scale must be
// finite and greater than 0, `p` between 0 and 1: InternalError otherwise. GSL's own inverse fails for a
// fifth of the shapes beyond 2000, so the distribution itself is inverted.
double gamma_quantile(double p, double shape, double scale);

}  // namespace trilat
