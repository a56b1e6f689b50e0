// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>

namespace trilat {

// The 97.5 % quantile of Student's t, for intervals of 95 %: a table up to 30 degrees of freedom, beyond it
// the expansion of Cornish and Fisher, which is then exact to six digits. 0 degrees are the caller's error.
inline double student_quantile(std::size_t degrees) {
  constexpr std::array<double, 30> kTable{
      12.706204736, 4.302652730, 3.182446305, 2.776445105, 2.570581836, 2.446911851, 2.364624252, 2.306004135,
      2.262157163,  2.228138852, 2.200985160, 2.178812830, 2.160368656, 2.144786688, 2.131449546, 2.119905299,
      2.109815578,  2.100922040, 2.093024054, 2.085963447, 2.079613845, 2.073873068, 2.068657610, 2.063898562,
      2.059538553,  2.055529439, 2.051830516, 2.048407142, 2.045229642, 2.042272456};
  if (degrees <= kTable.size()) return kTable.at(degrees - 1);
  constexpr double kNormal = 1.959963984540054;
  constexpr double z2 = kNormal * kNormal;
  const double n = static_cast<double>(degrees);
  return kNormal * (1.0 + (z2 + 1.0) / (4.0 * n) + (5.0 * z2 * z2 + 16.0 * z2 + 3.0) / (96.0 * n * n) +
                    (3.0 * z2 * z2 * z2 + 19.0 * z2 * z2 + 17.0 * z2 - 15.0) / (384.0 * n * n * n));
}

// The quantile of Student's t for two-sided intervals of any level, 1 - alpha; above 0, below 1.
double student_quantile(std::size_t degrees, double alpha);

// The probability that Student's t of so many degrees of freedom is at least as far from 0 as `t`, on either
// side. 1 for t = 0, 0 for infinite t, NaN for NaN or no degrees. Relative error below 1e-10 down to 1e-290.
double student_two_sided(double t, std::size_t degrees);

}  // namespace trilat
