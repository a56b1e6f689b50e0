// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "datasets/results/summary.h"

namespace trilat {

// What one method's mean error did from one set of results to another, in one condition and joint group. The
// interval is of 95 %, by Student's t between participants.
struct ErrorChange {
  std::string condition, group, method;
  double before_m = kNoNumber, after_m = kNoNumber;
  double difference_m = kNoNumber, low_m = kNoNumber, high_m = kNoNumber;  // after - before
  bool is_real() const { return low_m > kSameDistance_m || high_m < -kSameDistance_m; }
};

struct ErrorChanges {
  std::string before, after;     // the folders' names
  bool paired = false;           // the same participants in both: their differences are what is averaged
  std::size_t participants = 0;  // of the fewer
  std::vector<ErrorChange> rows;
};

}  // namespace trilat
