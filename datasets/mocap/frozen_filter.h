// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "datasets/mocap/mocap_reader.h"
#include "datasets/mocap/mocap_take.h"

namespace trilat {

// Some exports repeat the last pose of a lost body instead of leaving it out. The noise of a body
// that is truly still shows in the last digits, so a pose that stays the same to the bit is lost.
struct FrozenOptions {
  double min_s = 0.095;         // from the first to the last frame of the stretch
  std::int64_t min_frames = 5;  // and at least so many
};

// Follows one asset frame by frame.
class FrozenStretch {
 public:
  // How many of the frames so far are newly known to be frozen, this one being the last of them:
  // the whole stretch when it has just become long enough, then one at a time.
  std::int64_t add(const MocapPose& pose, bool present, MocapTime time, const FrozenOptions& options);

 private:
  MocapPose pose_;
  MocapTime start_;
  std::int64_t frames_ = 0;
  bool frozen_ = false;
};

// The frames of a reader in which every frozen pose is missing, from its first frame on, and so is one
// exactly at the origin, which some exports write for "lost": neither is a measurement. Reads ahead, and
// holds, no more than one shortest stretch.
class FrozenFilter {
 public:
  explicit FrozenFilter(MocapReader& reader, FrozenOptions options = {});
  bool next(MocapFrame& frame);
  // Poses taken out so far, for each asset of the header; a little ahead of the frames given.
  const std::vector<std::int64_t>& removed() const { return removed_; }

 private:
  bool is_decided() const;
  bool read_one();

  MocapReader& reader_;
  FrozenOptions options_;
  std::vector<FrozenStretch> stretches_;
  std::vector<std::int64_t> removed_;
  std::deque<MocapFrame> held_;
  MocapFrame frame_;
  bool ended_ = false;
};

}  // namespace trilat
