// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>

namespace trilat {

// The middle value; of an even number the upper one of both. `values` are put in another order; there must
// be one.
template <class Values>
auto upper_median(Values&& values) {
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The same, of an even number the mean of both.
template <class Values>
double median(Values&& values) {
  const double upper = upper_median(values);
  if (values.size() % 2 == 1) return upper;
  return 0.5 * (upper + *std::max_element(values.begin(), values.begin() + std::ssize(values) / 2));
}

}  // namespace trilat
