// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "datasets/mocap/frozen_stretch.h"
#include "datasets/mocap/optitrack_csv_reader.h"

namespace trilat {

// The frames of a reader in which every frozen pose is missing, from its first frame on, and so is one
// exactly at the origin, which some exports write for "lost": neither is a measurement. Reads ahead, and
// holds, no more than one shortest stretch.
class FrozenFilter {
 public:
  explicit FrozenFilter(OptitrackCsvReader& reader, FrozenOptions options = {});
  bool next(MocapFrame& frame);
  // Poses taken out so far, for each asset of the header; a little ahead of the frames given.
  const std::vector<std::int64_t>& removed() const { return removed_; }

 private:
  bool is_decided() const;
  bool read_one();

  OptitrackCsvReader& reader_;
  FrozenOptions options_;
  std::vector<FrozenStretch> stretches_;
  std::vector<std::int64_t> removed_;
  std::deque<MocapFrame> held_;
  MocapFrame frame_;
  bool ended_ = false;
};

}  // namespace trilat
