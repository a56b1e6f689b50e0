// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
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

// A column is a method on some of the samples that it answers: the first ones each on all of its own, the
// others on those that another method answers, too. Equal columns are one.
class AlignedColumns {
 public:
  // Finds the columns and, where an alignment learns anything, reads the samples once.
  AlignedColumns(const Windows& windows, const TakeHead& head, const SampleMarks& marks,
                 const ErrorSettings& settings);

  struct Column {
    std::size_t method;
    SampleSet samples;
  };
  const std::vector<Column>& columns() const { return columns_; }
  // The columns of a method beside that of all its samples.
  const std::vector<std::size_t>& more_of(std::size_t method) const { return columns_of_[method]; }
  // The columns of both methods of a pair of the settings.
  const std::pair<std::size_t, std::size_t>& of_pair(std::size_t pair) const { return pairs_[pair]; }
  const JointAlignment& alignment(std::size_t a, std::size_t column, std::size_t joint) const {
    return alignment_[(a * columns_.size() + column) * joints_ + joint];
  }
  std::vector<AlignmentRow> rows() const;

 private:
  struct AlignedSums {
    AlignmentSums whole;
    JointOffset trained;
  };
  std::size_t column_of(std::size_t method, const SampleSet& samples);
  void learn(const Window& w, std::size_t j, const Column& column, AlignedSums& sums) const;
  void solve(AlignmentKind kind, std::span<const AlignedSums> of_joints);

  const SampleMarks& marks_;
  std::size_t joints_, methods_, alignments_;
  std::uint64_t training_end_ = 0;
  bool turns_;  // an alignment has a rotation
  std::vector<Column> columns_;
  std::vector<std::vector<std::size_t>> columns_of_;        // by method
  std::vector<std::pair<std::size_t, std::size_t>> pairs_;  // by pair of the settings
  std::vector<JointAlignment> alignment_;                   // by alignment, column and joint
};

}  // namespace trilat
