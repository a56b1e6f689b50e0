// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "evaluators/alignment/alignment.h"
#include "pipeline/accuracy/plan.h"

namespace trilat {

// The axes of a results folder: what its samples are numbered by, and which cell of the summary a sample
// belongs to. Sets: all samples and, when the study wants them apart, those that a sensor sees occluded.
struct Axes {
  std::size_t joints = 0, methods = 0, groups = 0, alignments = 0, sets = 1;
  std::vector<std::size_t> group_of_joint;
  std::size_t cell(std::size_t set, std::size_t group, std::size_t method, std::size_t alignment) const {
    return ((set * groups + group) * methods + method) * alignments + alignment;
  }
  std::size_t cells() const { return sets * groups * methods * alignments; }
};

// Block sums of a study are kept in memory; blocks are made longer until they fit.
inline constexpr std::uint64_t kBlockSumBytes = 64'000'000;
inline constexpr std::uint64_t kMostBlocks = 4096;

// What the statistics of a study are made with. Depends on the plan alone, so every shard has the same.
struct StatisticsLayout {
  Axes axes;
  std::vector<AlignmentKind> alignments;
  double training_share = 0.0;                             // of a take's instants, at its start
  std::size_t reference = 0;                               // the method that the others are compared with
  std::vector<std::optional<std::size_t>> fallback;        // by method: whose answer stands where it has none
  std::size_t body_alignment = 0;                          // of whole bodies: none when the study has it
  double rate_hz = 30.0;                                   // of the instants
  std::uint64_t block_instants = 30;                       // that make one time block
  std::vector<std::pair<std::size_t, std::size_t>> bones;  // both ends, by joint of the study
  std::uint64_t blocks(std::uint64_t instants) const {
    return (instants + block_instants - 1) / block_instants;
  }
};

StatisticsLayout statistics_layout(const Plan& plan);

// The groups of the study's joints, in the order of the tables' numbers.
std::vector<std::string> groups_of(const Plan& plan);

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

}  // namespace trilat
