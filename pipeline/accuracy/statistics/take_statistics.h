// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "evaluators/metrics/cluster_ratios.h"
#include "evaluators/metrics/error_statistics.h"
#include "pipeline/accuracy/statistics/aligned_errors.h"
#include "pipeline/accuracy/statistics/paired_methods.h"

namespace trilat {

struct Mean {
  double sum = 0.0;
  std::uint64_t n = 0;
  void add(double value) {
    sum += value;
    ++n;
  }
  void merge(const Mean& later) {
    sum += later.sum;
    n += later.n;
  }
  double value() const { return n == 0 ? kNaN : sum / static_cast<double>(n); }
};

struct TakeBodies {
  std::array<std::uint64_t, 3> within{};  // of kPckRadii_m
  std::uint64_t joints = 0;               // asked
  std::uint64_t bones = 0;                // with both ends in this take
  Mean bone_sd_m, jerk_m_s3;
};

// Everything one take adds to one cell of its condition.
struct CellSums {
  ErrorSums errors;
  CompensatedSum iterations;
  // As if `later`'s samples had been added after what is here.
  void merge(const CellSums& later);
};

// A method and the reference on the same samples.
struct PairedSums {
  Mean method_m, reference_m;
};

// Of one joint and method under the first alignment, in one set of samples.
struct JointSums {
  std::uint64_t asked = 0;
  Mean distance_m;      // of what was answered
  PairedSums both;      // where both answer
  PairedSums complete;  // where any of the two answers: its error stands for both where the other is silent
  Mean slow_m, fast_m;  // of what was answered, in the slower and the faster half of the joint's samples
};

struct TakeStatistics {
  std::vector<CellSums> sums;       // by cell
  RowMatrix cells;                  // blocks x (cells of the axes x CellColumns)
  RowMatrix bodies;                 // blocks x (methods x BodySumColumns)
  std::vector<JointSums> of_joint;  // (set * joints + joint) * methods + method
  std::vector<TakeBodies> of_method;
  std::vector<Mean> truth_speed_m_s;  // by group
  Mean truth_jerk_m_s3;
};

// What one take adds to the summary of a study, made from its samples alone.
struct TakeSummary {
  TakeStatistics statistics;
  std::vector<std::vector<double>> distances_m;  // by cell, |error| of its answered samples
  PairTable pairs;
};

// The layout of the samples of a take.
SamplesHeader samples_header(const Plan& plan, const PlannedTake& take);

// Streams the take's samples. `errors`: a file of the same take, or null; there the errors under the first
// alignment are written.
TakeSummary summarise_take(const SamplesFile& samples, const StatisticsLayout& layout, SamplesFile* errors);

}  // namespace trilat
