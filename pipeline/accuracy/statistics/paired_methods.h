// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/accuracy/statistics/aligned_errors.h"

namespace trilat {

// The errors of two methods on the samples that both answer, each aligned on just these.
struct PairSums {
  std::uint64_t n = 0;
  double first_m = 0.0, second_m = 0.0;
};

// Of one take under the study's first alignment: every two methods that compete.
struct PairTable {
  std::size_t joints = 0, methods = 0;  // competitors, by their place in the layout's list
  std::vector<PairSums> cells;
  const PairSums& at(std::size_t set, std::size_t joint, std::size_t first, std::size_t second) const {
    return cells[((set * joints + joint) * methods + first) * methods + second];
  }
};

// Reads the take's positions three times; from memory where they are below 64 MB.
PairTable pair_methods(const SamplesFile& samples, const StatisticsLayout& layout);

}  // namespace trilat
