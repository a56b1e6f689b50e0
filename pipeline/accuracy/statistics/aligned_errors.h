// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "datasets/results/samples.h"
#include "evaluators/alignment/alignment.h"
#include "evaluators/solvers/point_estimate.h"
#include "pipeline/accuracy/take/plan.h"

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

// With fewer participants than this takes are the clusters of intervals.
inline constexpr std::size_t kFewestParticipants = 3;

// What the statistics of a study are made with. Depends on the plan alone, so every shard has the same.
struct StatisticsLayout {
  Axes axes;
  std::vector<AlignmentKind> alignments;
  double training_share = 0.0;                             // of a take's instants, at its start
  std::size_t reference = 0;                               // the method that the others are compared with
  std::vector<std::size_t> competitors;                    // methods of which one is the best
  std::size_t body_alignment = 0;                          // of whole bodies: none when the study has it
  double rate_hz = 30.0;                                   // of the instants
  std::vector<std::pair<std::size_t, std::size_t>> bones;  // both ends, by joint of the study
  // A time block of a take of so many instants: five seconds, a twelfth of the take where that is longer.
  std::uint64_t block_instants(std::uint64_t instants) const;
  std::uint64_t blocks(std::uint64_t instants) const {
    return instants == 0 ? 0 : (instants - 1) / block_instants(instants) + 1;
  }
  // The first instant that no alignment is trained on.
  std::uint64_t training_end(std::uint64_t instants) const;
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

// How one joint and method of a take is laid over the truth.
struct JointAlignment {
  AlignmentKind kind = AlignmentKind::none;
  Alignment alignment;              // of every kind but joint_offset
  JointOffset offset;               // of joint_offset
  std::uint64_t first_instant = 0;  // those before were trained on and do not count
  bool turns = true;                // false: the alignment only moves

  Eigen::Vector3d aligned_m(const Eigen::Vector3d& estimate_m, double heading_rad) const {
    if (kind == AlignmentKind::joint_offset) return offset.corrected(estimate_m, heading_rad);
    if (alignment.status != AlignmentStatus::aligned) return Eigen::Vector3d::Constant(kNaN);
    if (!turns) return estimate_m + alignment.truth_from_estimate.translation_m;
    return alignment.truth_from_estimate * estimate_m;
  }
};

using AlignmentTable = std::vector<JointAlignment>;  // joint * methods + method

// One take under one kind of alignment. A method's error is taken with the alignment of all its answers.
// Where it is compared with the reference, both are aligned on the samples that both answer: one that answers
// less would else be fitted to just these, and look better for it.
struct KindAlignments {
  AlignmentTable own;
  AlignmentTable on_both;            // the method's, on samples that the reference answers too
  AlignmentTable reference_on_both;  // the reference's, on samples that the method answers too
};
using TakeAlignments = std::vector<KindAlignments>;  // by kind

// One block of samples, addressed by instant, joint and method.
struct SampleView {
  const SampleBlock& block;
  const Axes& axes;
  std::size_t slot(std::uint64_t i, std::size_t j, std::size_t m) const {
    return (i * axes.joints + j) * axes.methods + m;
  }
  Eigen::Vector3d truth(std::uint64_t i, std::size_t j) const {
    return Eigen::Map<const Eigen::Vector3d>(&block.truth_m[(i * axes.joints + j) * 3]);
  }
  Eigen::Vector3d estimate(std::size_t slot) const {
    return Eigen::Map<const Eigen::Vector3d>(&block.estimate_m[slot * 3]);
  }
  // How many sets the joint's samples of this instant belong to, from the first on.
  std::size_t sets(std::uint64_t i, std::size_t j) const {
    return axes.sets == 1 || block.occluded[i * axes.joints + j] == 0 ? 1 : 2;
  }
  double heading_rad(std::uint64_t i) const { return static_cast<double>(block.heading_rad[i]); }
  SolveStatus status(std::size_t slot) const { return static_cast<SolveStatus>(block.status[slot]); }
};

// Calls visit(i, j, m, slot, view) for every sample that has a truth.
template <class Visit>
void visit_samples(const SampleBlock& block, const Axes& axes, const Visit& visit) {
  const SampleView view{block, axes};
  for (std::uint64_t i = 0; i < block.instants; ++i)
    for (std::size_t j = 0; j < axes.joints; ++j) {
      if (!view.truth(i, j).allFinite()) continue;
      for (std::size_t m = 0; m < axes.methods; ++m) visit(i, j, m, view.slot(i, j, m), view);
    }
}

// The same block by block, and calls end_block(block) behind each.
template <class Visit, class EndBlock>
void stream_take(const SamplesFile& samples, const Axes& axes, SampleColumns columns, const Visit& visit,
                 const EndBlock& end_block) {
  constexpr std::uint64_t kBlock = 1024;
  const std::uint64_t instants = samples.header().takes[0].instants;
  SampleBlock block;
  for (std::uint64_t first = 0; first < instants; first += kBlock) {
    samples.read(0, first, std::min(kBlock, instants - first), columns, block);
    visit_samples(block, axes, visit);
    end_block(block);
  }
}

// What the alignments of one joint and method are made from.
struct AlignedSums {
  AlignmentSums whole;
  JointOffset trained;
  void add(const SampleView& view, std::uint64_t i, std::size_t j, std::size_t slot,
           std::uint64_t training_end) {
    whole.add(view.estimate(slot), view.truth(i, j));
    if (view.block.first_instant + i < training_end && std::isfinite(view.heading_rad(i)))
      trained.add(view.estimate(slot), view.truth(i, j), view.heading_rad(i));
  }
};
// `sums`: of each joint the same number of columns.
AlignmentTable solve_alignments(std::span<const AlignedSums> sums, std::size_t joints, AlignmentKind kind,
                                std::uint64_t training_end);

TakeAlignments align_take(const SamplesFile& samples, const StatisticsLayout& layout);
// Of a whole take in memory.
TakeAlignments align_take(const SampleBlock& samples, const StatisticsLayout& layout);

// The error after alignment. A usable estimate whose alignment failed has no error and counts as not solved;
// what was trained on is not asked.
struct AlignedError {
  SolveStatus status = SolveStatus::not_solved;
  Eigen::Vector3d error_m = Eigen::Vector3d::Constant(kNaN);
  bool asked = true;
};
inline AlignedError error_of(const SampleView& view, std::uint64_t i, std::size_t j, std::size_t slot,
                             const JointAlignment& alignment) {
  AlignedError result;
  result.asked = view.block.first_instant + i >= alignment.first_instant;
  if (!result.asked) return result;
  const SolveStatus status = view.status(slot);
  if (!is_usable(status)) {
    result.status = status;
    return result;
  }
  const Eigen::Vector3d aligned_m = alignment.aligned_m(view.estimate(slot), view.heading_rad(i));
  if (!aligned_m.allFinite()) return result;
  result.status = status;
  result.error_m = aligned_m - view.truth(i, j);
  return result;
}
inline AlignedError error_of(const SampleView& view, std::uint64_t i, std::size_t j, std::size_t m,
                             std::size_t slot, const AlignmentTable& alignments) {
  return error_of(view, i, j, slot, alignments[j * view.axes.methods + m]);
}

// The mean error of each method (row) over the samples that each other one (column) answers too, both aligned
// on these; of a method with itself over all its answers. In metres, the mean of the joint groups, of the
// takes of one condition; NaN where a group has no such sample. One such table behind the other for each
// alignment of the layout.
std::vector<double> paired_errors_m(const std::filesystem::path& results, const std::string& condition,
                                    StatisticsLayout layout);

}  // namespace trilat
