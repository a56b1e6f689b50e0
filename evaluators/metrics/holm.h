// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

namespace trilat {

// Probabilities of chance, corrected for how many are looked at (Holm 1979): rejecting what comes out at or
// below alpha makes one false rejection or more with probability alpha at most, however they depend on each
// other. NaN is no test: it stays NaN and counts for none.
std::vector<double> holm_adjusted(std::span<const double> p);

// The level that each is held against when all together may have `alpha`: it comes out at or below it just
// when its corrected probability comes out at or below `alpha`. An interval of 1 - level thus says the same
// as the test.
std::vector<double> holm_levels(std::span<const double> p, double alpha);

}  // namespace trilat
