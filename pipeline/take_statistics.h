// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "evaluators/metrics/cluster_ratios.h"
#include "pipeline/aligned_errors.h"

namespace trilat {

// What the statistics of a study are made with.
struct StatisticsLayout {
  Axes axes;
  std::size_t reference = 0;                               // the method that the others are compared with
  std::size_t body_alignment = 0;                          // of whole bodies: none when the study has it
  double rate_hz = 30.0;                                   // of the instants
  std::uint64_t block_instants = 30;                       // that make one time block
  std::vector<std::pair<std::size_t, std::size_t>> bones;  // both ends, by joint of the study
  std::uint64_t blocks(std::uint64_t instants) const {
    return (instants + block_instants - 1) / block_instants;
  }
};

// Columns of the block sums. Of every cell, over the samples that a method answered: distances and their
// number; and over those that the reference answered too: the difference of the distances, their number and
// the reference's distances.
struct CellColumns {
  static constexpr std::size_t distance = 0, answered = 1, difference = 2, both = 3, reference = 4, count = 5;
};
// Of every method, over the instants of whole bodies: see body_metrics.h.
struct BodySumColumns {
  static constexpr std::size_t mpjpe = 0, whole = 1, pa_mpjpe = 2, pa_whole = 3, count = 4;
};

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

// How much a cell's distances change when the truth is that of the next or the previous instant.
struct OneFrame {
  Mean later_m, earlier_m;
};

struct TakeBodies {
  std::array<std::uint64_t, 3> within{};  // of kPckRadii_m
  std::uint64_t joints = 0;               // asked
  std::uint64_t bones = 0;                // with both ends in this take
  Mean bone_sd_m, jerk_m_s3;
};

// The truth of one group.
struct TakeTruth {
  Mean speed_m_s;
  std::vector<double> noise_sigma_m;  // an axis, by block that has any
};

struct TakeStatistics {
  RowMatrix cells;                  // blocks x (cells of the axes x CellColumns)
  RowMatrix bodies;                 // blocks x (methods x BodySumColumns)
  std::vector<OneFrame> one_frame;  // by cell
  std::vector<TakeBodies> of_method;
  std::vector<TakeTruth> of_group;
  Mean truth_jerk_m_s3;
};

// Streams one take's samples once.
TakeStatistics gather_take(const SamplesFile& samples, std::size_t take, const StatisticsLayout& layout,
                           const TakeAlignments& alignments);

}  // namespace trilat
