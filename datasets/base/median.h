// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <vector>

namespace trilat {

// The middle value; of an even number the upper one of both. There must be one.
template <class T>
T upper_median(std::vector<T> values) {
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Median; of an even number the mean of both in the middle.
inline double median(std::vector<double> values) {
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::nth_element(values.begin(), middle, values.end());
  return values.size() % 2 == 1 ? *middle : 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

}  // namespace trilat
