// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

namespace trilat {

// The probability that Student's t of so many degrees of freedom is at least as far from 0 as `t`, on either
// side. 1 for t = 0, 0 for infinite t, NaN for NaN or no degrees. Relative error below 1e-10 down to 1e-290.
double student_two_sided(double t, std::size_t degrees);

}  // namespace trilat
