// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "datasets/results/stored_take.h"
#include "datasets/results/take_errors.h"
#include "evaluators/alignment/alignment.h"
#include "evaluators/solvers/point_estimate.h"
#include "pipeline/errors/take_errors.h"

namespace trilat {

// Joints at instants, one bit each.
class SampleSet {
 public:
  explicit SampleSet(std::size_t size) : words_((size + 63) / 64) {}
  void add(std::size_t k) { words_[k / 64] |= std::uint64_t{1} << (k % 64); }
  bool has(std::size_t k) const { return (words_[k / 64] >> (k % 64) & 1) != 0; }
  SampleSet operator&(const SampleSet& other) const {
    SampleSet both(0);
    for (std::size_t w = 0; w < words_.size(); ++w) both.words_.push_back(words_[w] & other.words_[w]);
    return both;
  }
  bool operator==(const SampleSet&) const = default;

 private:
  std::vector<std::uint64_t> words_;
};

// Instants [first, end) of a take, none of another block of time; `block` holds those around them, too.
struct Window {
  const SampleBlock& block;
  std::uint64_t first, end;
  std::size_t joints, methods;

  std::uint64_t begins() const { return block.first_instant; }
  std::uint64_t ends() const { return block.first_instant + block.instants; }
  std::size_t place(std::uint64_t i, std::size_t j) const { return (i - block.first_instant) * joints + j; }
  std::size_t slot(std::uint64_t i, std::size_t j, std::size_t m) const { return place(i, j) * methods + m; }
  Eigen::Map<const Eigen::Vector3d> truth_m(std::uint64_t i, std::size_t j) const {
    return Eigen::Map<const Eigen::Vector3d>(&block.truth_m[place(i, j) * 3]);
  }
  Eigen::Vector3d estimate_m(std::size_t slot) const {
    return Eigen::Map<const Eigen::Vector3f>(&block.estimate_m[slot * 3]).cast<double>();
  }
  bool has_truth(std::uint64_t i, std::size_t j) const { return truth_m(i, j).allFinite(); }
  SolveStatus status(std::size_t slot) const { return static_cast<SolveStatus>(block.status[slot]); }
};

// The windows of a take, as often as it takes.
class Windows {
  static constexpr std::uint64_t kInMemoryBytes = 64'000'000;
  static constexpr std::uint64_t kRead = 512;     // instants that are read together
  static constexpr std::uint64_t kMinCount = 16;  // instants that are looked at together
  static constexpr std::size_t kNear = 1 << 16;   // bytes of estimates that stay in the cache

 public:
  // `of_block`: instants of a block; `margin`: instants that a window holds on either side of its own.
  Windows(const StoredTake& take, std::size_t track, std::uint64_t of_block, std::uint64_t margin)
      : take_(take), track_(track), of_block_(of_block), margin_(margin) {
    const TakeHead& head = take.head();
    if (head.instants * head.joints.size() * head.methods.size() * sizeof(float) * 4 <= kInMemoryBytes)
      whole_ = take.read(track, 0, head.instants, SampleColumns::errors);
    const std::size_t bytes =
        std::max<std::size_t>(1, head.joints.size() * head.methods.size()) * 3 * sizeof(float);
    together_ = whole_ ? std::max<std::uint64_t>(kMinCount, kNear / bytes) : kRead;
  }
  // Calls visit(window) in the order of time, and end_block(number) behind each block of time.
  template <class Visit, class EndBlock>
  void each(const Visit& visit, const EndBlock& end_block) const {
    const TakeHead& head = take_.head();
    SampleBlock part;
    std::uint32_t block = 0;
    for (std::uint64_t first = 0; first < head.instants;) {
      const std::uint64_t end_of_block = std::min(head.instants, (block + 1) * of_block_);
      const std::uint64_t end = std::min(end_of_block, first + together_);
      if (!whole_) {
        const std::uint64_t from = first - std::min(first, margin_);
        take_.read(track_, from, std::min(end + margin_, head.instants) - from, SampleColumns::errors, part);
      }
      visit(Window{whole_ ? *whole_ : part, first, end, head.joints.size(), head.methods.size()});
      first = end;
      if (end == end_of_block) end_block(block++);
    }
  }
  template <class Visit>
  void each(const Visit& visit) const {
    each(visit, [](std::uint32_t) {});
  }

 private:
  const StoredTake& take_;
  std::size_t track_;
  std::uint64_t of_block_, margin_, together_;
  std::optional<SampleBlock> whole_;
};

// Parts of the samples that are asked: not occluded, and occluded.
inline constexpr std::size_t kSubsetCombinations = 2;
constexpr bool is_part_of(std::size_t part, Subset subset) { return subset == Subset::all || part == 1; }

// Flags of the samples of a track: whether each is asked, its subset, and which methods answer. A sample is
// asked where its truth is known.
class SampleFlags {
 public:
  // Reads the samples once.
  SampleFlags(const Windows& windows, const TakeHead& head);

  std::size_t place(std::uint64_t instant, std::size_t joint) const { return joint * instants_ + instant; }
  bool is_asked(std::uint64_t instant, std::size_t joint) const {
    return (marks_[place(instant, joint)] & kAsked) != 0;
  }
  std::size_t subset_of(std::uint64_t instant, std::size_t joint) const {
    return marks_[place(instant, joint)] >> 1U;
  }
  const std::vector<SampleSet>& answered() const { return answered_; }  // by method, over place()

 private:
  static constexpr std::uint8_t kAsked = 1, kOccluded = 2;

  std::uint64_t instants_;
  std::vector<std::uint8_t> marks_;  // by joint and instant
  std::vector<SampleSet> answered_;
};

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
