// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "datasets/base/strict_json.h"
#include "datasets/results/studies/sweep_summary.h"
#include "evaluators/metrics/error_statistics.h"
#include "pipeline/sweep/sweep_sums.h"

namespace trilat {

// Sums over chunks of one cell. Equal chunks give the same cell, to the bit, in whatever order and groups
// they were added, by whatever processes.
struct SweepTotals {
  SweepCounts counts;
  std::array<ExactSum, SweepSums::kTerms> sum;

  void add(const SweepSums& chunk);
  void add(const SweepTotals& other);
  // Everything but the cell's place.
  SweepCell cell() const;
};

Json json_of(const SweepTotals& totals);
SweepTotals read_sweep_totals(JsonObject object);

}  // namespace trilat
