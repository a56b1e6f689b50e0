// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "evaluators/alignment/alignment.h"
#include "pipeline/errors/take_errors.h"
#include "pipeline/errors/track_samples.h"

namespace trilat {

// How the samples of one joint and column are laid over the truth.
struct JointAlignment {
  AlignmentKind kind = AlignmentKind::none;
  Alignment alignment;              // of every kind but joint_offset
  JointOffset offset;               // of joint_offset
  std::uint64_t first_instant = 0;  // those before were learnt from and do not count
  bool turns = true;                // false: the alignment only moves
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();

  Eigen::Vector3d aligned_m(const Eigen::Vector3d& estimate_m, double heading_rad) const {
    if (!turns) return estimate_m + shift_m;
    if (kind == AlignmentKind::joint_offset) return offset.corrected(estimate_m, heading_rad);
    if (alignment.status != AlignmentStatus::aligned) return Eigen::Vector3d::Constant(kNaN);
    return alignment.truth_from_estimate * estimate_m;
  }
};

// A method on some of the samples that it answers.
struct SampleColumn {
  std::size_t method;
  SampleSet samples;
};

// Alignments of columns, each learnt from its own samples.
class ColumnAlignments {
 public:
  // Reads the samples once where an alignment learns anything.
  ColumnAlignments(const Windows& windows, const TakeHead& head, const SampleFlags& marks,
                   const ErrorSettings& settings, std::span<const SampleColumn> columns);

  const JointAlignment& of(std::size_t alignment, std::size_t column, std::size_t joint) const {
    return solved_[(alignment * columns_ + column) * joints_ + joint];
  }
  // Where each column is a method by itself.
  std::vector<AlignmentRow> rows() const;

 private:
  struct AlignedSums {
    AlignmentSums whole;
    JointOffset trained;
  };
  void learn(const Window& w, std::size_t j, const SampleColumn& column, AlignedSums& sums) const;
  void solve(AlignmentKind kind, std::span<const AlignedSums> of_joints);

  const SampleFlags& marks_;
  std::size_t joints_, columns_;
  std::uint64_t training_end_;
  bool turns_;                          // an alignment has a rotation
  std::vector<JointAlignment> solved_;  // by alignment, column and joint
};

}  // namespace trilat
