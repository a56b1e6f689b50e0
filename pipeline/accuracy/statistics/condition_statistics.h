// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/results/summary.h"
#include "evaluators/metrics/block_bootstrap.h"
#include "pipeline/accuracy/statistics/take_statistics.h"

namespace trilat {

// The takes of one activity that were evaluated, those of one participant together.
struct ConditionTakes {
  std::vector<const TakeStatistics*> takes;
  std::vector<std::size_t> participant;  // by take, from 0
  BlockResamples resamples;
};

ConditionTakes condition_takes(std::vector<const TakeStatistics*> takes, std::vector<std::size_t> participant,
                               const ResampleOptions& options);

// What the intervals of one method are, in one set of samples.
struct CellInterval {
  std::size_t group = 0;  // that of the axes, or their number: the average
  std::size_t alignment = 0;
  double low_m = kNoNumber, high_m = kNoNumber;
  std::uint64_t clusters = 0;
  double one_frame_m = kNoNumber;
};
struct MethodIntervals {
  std::vector<CellInterval> cells;
  std::vector<DifferenceCell> differences;  // without names; empty for the reference
};

// By alignment and group, each followed by the average of the groups when there are two or more. `groups`:
// those that were asked for.
MethodIntervals method_intervals(const ConditionTakes& condition, const StatisticsLayout& layout,
                                 std::size_t set, std::size_t method, const std::vector<std::size_t>& groups);

// Without names.
BodyCell body_cell(const ConditionTakes& condition, std::size_t method);
TruthFloor truth_floor(const ConditionTakes& condition, std::size_t group, double clock_error_s);

}  // namespace trilat
